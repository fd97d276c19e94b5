"""Parameters of a mould. The thesis describes the features of moulds (3.2.1), not their
sizes: the defaults are ours.
"""

from __future__ import annotations

from dataclasses import dataclass, field, fields
from typing import Any


def _size(default: float, low: float, high: float, unit: str, text: str) -> Any:
    return field(default=default, metadata={"low": low, "high": high, "unit": unit, "text": text})


@dataclass(frozen=True)
class MouldParameters:
    """Sizes [mm], the draft [deg] and the shrinkage [%]; raises ValueError for a value outside of
    its limits.

    >>> MouldParameters(groove_pitch=0.0)
    Traceback (most recent call last):
    ValueError: groove_pitch: expected 2.6 to 20 mm, got 0
    """

    draft: float = _size(
        3.0, -10.0, 10.0, "deg", "slant of the walls; checks pass 2.8 to 3.2 alone"
    )
    fillet: float = _size(1.0, 0.2, 5.0, "mm", "radius of the edges of chamber and back")
    plug: float = _size(3.0, 1.0, 20.0, "mm", "rubber between chamber and either end")
    groove_pitch: float = _size(3.0, 2.6, 20.0, "mm", "distance of the grooves of the thread")
    groove_depth: float = _size(0.4, 0.1, 1.0, "mm", "their depth, and the height of the nubs")
    thread: float = _size(0.5, 0.2, 1.0, "mm", "width of their bottom")
    step: float = _size(0.8, 0.2, 2.0, "mm", "amplitude of the step between the parts")
    step_period: float = _size(12.0, 8.0, 50.0, "mm", "period of the step along the rim")
    rim: float = _size(8.0, 5.0, 30.0, "mm", "width of the rim for the clips, beside the shell")
    shell: float = _size(3.0, 1.2, 10.0, "mm", "thickness of shell, rim and plate")
    clearance: float = _size(0.15, 0.02, 0.5, "mm", "gap of the parts in the step")
    shrinkage: float = _size(0.1, 0.0, 2.0, "%", "of the rubber, by which the mould is larger")

    def __post_init__(self) -> None:
        for entry in fields(self):
            value, bounds = getattr(self, entry.name), entry.metadata
            if not bounds["low"] <= value <= bounds["high"]:
                raise ValueError(
                    f"{entry.name}: expected {bounds['low']:g} to {bounds['high']:g} "
                    f"{bounds['unit']}, got {value:g}"
                )

    @property
    def reach(self) -> float:
        """Distance [mm] from the cavity to the edge of the rim."""
        return self.shell + self.rim

    @property
    def edge(self) -> float:
        """Radius [mm] of the outer edges, which grooves follow without folding."""
        return max(self.fillet, 1.25 * self.groove_depth)

    @property
    def plate(self) -> float:
        """Thickness [mm] of plate and rim from the plane of the passive layer."""
        return self.shell + self.step

    @property
    def scale(self) -> float:
        """Size of the mould divided by that of the cured rubber [-]."""
        return 1.0 + self.shrinkage / 100.0
