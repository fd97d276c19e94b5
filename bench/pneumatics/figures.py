"""The figures of the table, by the group that measures them."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Figure:
    """One row: what, unit, the thesis's result, and the target.

    `limit` is the target, at most if `most`, else at least; None for a figure without one.
    """

    name: str
    unit: str
    thesis: str
    limit: float | None = None
    most: bool = True

    def worst(self, values: list[float]) -> float:
        """The value furthest on the wrong side."""
        return max(values) if self.most else min(values)


GROUPS = {
    "pulses": (
        Figure("RMS pulse error, deflation: baseline / full model", "", "7", 7.0, most=False),
        Figure("RMS pulse error, deflation: full model / sensor noise", "", "-", 1.5),
        Figure("RMS pulse error, inflation: full model / sensor noise", "", "-", 1.5),
    ),
    "sine": (
        Figure("final drift, 60 s sine, by the sensors", "mg", "< 2.5 but one", 2.5),
        Figure("final drift, 60 s sine, true", "mg", "< 2.5 but one", 2.5),
        Figure("shared calibration: mean error, shared / own", "", "about 4"),
        Figure("shared calibration: the driver warns", "", "-", 1.0, most=False),
    ),
    "finger": (Figure("final drift of fingers, corrected, one tare", "mg", "-", 1.0),),
    "supply": (Figure("supply varied by 25 %: change of tracking error", "%", "no effect", 10.0),),
    "loop": (Figure("8 channels, 500 Hz: p99 lateness above an empty loop", "ms", "-", 0.3),),
    "process": (Figure("8 channels, 500 Hz: share of one core", "%", "embedded board", 25.0),),
    "faults": (
        Figure("faults survived", "%", "-", 100.0, most=False),
        Figure("faults that stay silent", "", "-", 0.0),
    ),
}
PARALLEL = ("pulses", "sine", "finger", "supply", "faults")
ALONE = ("loop", "process")  # they measure time: nothing else may run beside them
