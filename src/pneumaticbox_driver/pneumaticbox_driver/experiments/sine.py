"""The sine of air mass that most experiments follow."""

from dataclasses import dataclass

import numpy as np

from pneumaticbox_driver.commands import TrajectoryPoint
from pneumaticbox_driver.experiments.report import Floats, option

KNOT = 0.05  # between the points of a command [s]


@dataclass(frozen=True)
class Sine:
    """Targets of air mass: a step from rest, later `mean - amplitude cos`, then its last value.

    The defaults are such that the box needs about the 122 pulses of Fig. 4.9 for them, on a
    bottle at about the pressure at which a finger works.

    >>> (1e6 * Sine().at(np.array([0.0, 8.0, 18.0]))).round(3).tolist()  # mg
    [130.0, 130.0, 170.0]
    """

    duration: float = option(60.0, "time of the sine [s]")
    mean: float = option(150e-6, "mean air mass of the sine above the fill at rest [kg]")
    amplitude: float = option(20e-6, "amplitude of the sine [kg]")
    period: float = option(20.0, "period of the sine [s]")
    fill: float = option(8.0, "time to fill the channels to where the sine starts [s]")

    def __post_init__(self) -> None:
        for name in ("duration", "period", "fill"):
            if not getattr(self, name) > 0:
                raise ValueError(f"{name} must be above 0 s, got {getattr(self, name)}")
        if not 0 < self.amplitude < self.mean:
            # a target of zero empties the channel and tares it
            got = f"{self.amplitude} and {self.mean}"
            raise ValueError(f"amplitude must be above 0 kg and below the mean, got {got}")

    @property
    def end(self) -> float:
        """When the sine is over, counted from the step at rest [s]."""
        return self.fill + self.duration

    def at(self, time: Floats) -> Floats:
        """Targets at times counted from the step at rest [s], in the times' shape [kg]."""
        phase = 2 * np.pi * (np.clip(time, self.fill, self.end) - self.fill) / self.period
        return np.asarray(self.mean - self.amplitude * np.cos(phase))

    def trajectory(self, channels: int) -> list[TrajectoryPoint]:
        """The command for all channels, a point every 50 ms."""
        times = np.arange(round(self.end / KNOT) + 1) * KNOT
        return [
            TrajectoryPoint(float(time), [float(mass)] * channels)
            for time, mass in zip(times, self.at(times), strict=True)
        ]
