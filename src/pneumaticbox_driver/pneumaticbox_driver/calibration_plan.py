"""What a calibration is to do: pulses, supply pressures, ranges, leak test."""

import math
from dataclasses import dataclass, field

from pneumaticbox_driver.recording import SETTLING
from pneumaticbox_driver.see_saw import SeeSawPlan

LEAST_CHANGE = 10e3  # between two supply pressures, or they do not tell the terms [Pa]


@dataclass(frozen=True)
class CalibrationPlan:
    """Plan of a calibration.

    `points` pulses per channel, both directions and all supply pressures together; `supplies` is
    how many supply pressures there are, between which the run waits for the user; `see_saw` gives
    the ranges of the pulses, `settling` and `averaging` [s] the rest between them; `leak_test` [s]
    is how long the closed channels are watched at the end, 0 for not at all.

    Raises:
        ValueError: naming the entry, what was expected and what was found.
    """

    points: int = 400
    supplies: int = 2
    see_saw: SeeSawPlan = field(default_factory=SeeSawPlan)
    settling: float = SETTLING
    averaging: float = 0.8  # longer than a single pulse needs: few points have to do
    leak_test: float = 30.0

    def __post_init__(self) -> None:
        if self.supplies < 1:
            raise ValueError(f"supplies must be at least 1, got {self.supplies}")
        least = 12 * self.supplies
        if self.points < least:
            raise ValueError(
                f"points must be at least {least} for {self.supplies} supply pressures, "
                f"got {self.points}"
            )
        for name in ("settling", "averaging"):
            value = getattr(self, name)
            if not (math.isfinite(value) and value > 0):
                raise ValueError(f"{name} must be above 0 s, got {value}")
        if not (math.isfinite(self.leak_test) and self.leak_test >= 0):
            raise ValueError(f"leak_test must be 0 s or above, got {self.leak_test}")

    @property
    def cycles(self) -> int:
        """Inflations, and deflations, per channel and supply pressure."""
        return math.ceil(self.points / (2 * self.supplies))
