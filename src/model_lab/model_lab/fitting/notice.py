"""An anomaly of a set, as it is reported."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from model_lab.aliases import Array, IntArray

NAMED_RUNS = 3  # runs or pairs of runs that are named


@dataclass(frozen=True)
class Notice:
    """An anomaly of a set.

    kind: `repeats`, `line`, `wild_samples`, `drift`, `apart`, `zero`, `driven`, `held_input`,
    `clipped`, `gaps`, `size`, `absolute`, `duration`, `pulses`, `single_sample` or `left_out`;
    in a diagnosis also `castings` (`diagnosis.own_moduli`), without points.
    value: by kind, in this order: ratio to the stated noise; frequency [Hz]; number of samples;
    change over the session, largest and rms difference of repeats, all in the SI unit of the
    outputs; number of runs; number of jumps; number of runs; longest gap [s]; ratio to the
    readings; smallest pressure [Pa]; median duration [s]; median of the integrals over
    what is expected; number of runs, for the last two. size: root mean square, or mean of absolute
    values, in the SI unit of the outputs. text: a clause that says it. x, y: the points that show
    it. marked: indices of points that stand out.
    """

    kind: str
    value: float
    size: float
    text: str
    x: Array
    y: Array
    marked: IntArray

    def as_json(self) -> dict[str, Any]:
        """The notice as a dictionary, without the points."""
        return {"kind": self.kind, "value": self.value, "size": self.size, "text": self.text}
