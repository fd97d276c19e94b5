"""The simulated finger against rods without segments: a Cosserat rod and one of PyElastica.

Solvers are those of the tests (`test/support`). `python -m bench.cosserat_rod` prints a table in
Markdown.
"""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import numpy as np

from bench.command_line import command_line
from bench.row import at_most, stated
from softhand_model.hand.actuator import load_actuator
from thesis.chapter_3_and_5.stand import FingerStand
from thesis.chapter_3_and_5.static_finger import blocked_finger

_SUPPORT = str(Path(__file__).resolve().parents[1] / "test" / "support")
if _SUPPORT not in sys.path:
    sys.path.append(_SUPPORT)

import cosserat  # noqa: E402 (from test/support)
import elastica_finger  # noqa: E402

FINGER = load_actuator("P10.finger")
SEGMENTS, PRESSURE, GAP, BLOCK_BOTTOM = 10, 40e3, 0.015, 0.07


def simulated_tips() -> tuple[np.ndarray, np.ndarray, float]:
    """Free and blocked tip (2,) [m] of the simulated finger, and the force [N] on the block."""
    with FingerStand(FINGER, SEGMENTS) as stand:
        stand.settle(PRESSURE)
        free = stand.line()[-1, [0, 2]]
        stand.settle(0.0)
        block = stand.block(GAP, BLOCK_BOTTOM)
        stand.settle(PRESSURE)
        return free, stand.line()[-1, [0, 2]], stand.touch(block).force


def run() -> list[dict[str, Any]]:
    """Rows of the benchmark."""
    free, tip, force = simulated_tips()
    rod = cosserat.rod_of(FINGER, PRESSURE)
    smooth_free, smooth = cosserat.free(rod), cosserat.blocked(rod, GAP)
    elastica_free, elastica = elastica_finger.rest(rod), elastica_finger.rest(rod, GAP)
    chain = blocked_finger(FINGER, SEGMENTS, PRESSURE, GAP)
    what = f"finger of {SEGMENTS} segments at {PRESSURE / 1e3:g} kPa"
    return [
        stated(f"{what}, blocked: force", force, "N"),
        at_most(f"{what}, free: tip against the Cosserat rod", _apart(free, smooth_free), "%", 1.0),
        at_most(f"{what}, blocked: tip against the Cosserat rod", _apart(tip, smooth), "%", 1.0),
        at_most(f"{what}, blocked: force against it", _off(force, smooth.tip_force), "%", 1.0),
        at_most(
            f"{what}, blocked: force against the same static chain",
            _off(force, chain.tip_force),
            "%",
            0.1,
        ),
        at_most(f"{what}, free: tip against PyElastica", _apart(free, elastica_free), "%", 1.0),
        at_most(f"{what}, blocked: tip against PyElastica", _apart(tip, elastica), "%", 1.0),
        at_most(f"{what}, blocked: force against it", _off(force, elastica.tip_force), "%", 1.0),
    ]


def _apart(tip: np.ndarray, other: Any) -> float:
    """Distance [% of the length] to another finger's tip."""
    return 100.0 * float(np.linalg.norm(tip - other.tip)) / FINGER.length


def _off(value: float, other: float) -> float:
    return 100.0 * abs(value / other - 1.0)


def markdown(rows: list[dict[str, Any]]) -> str:
    """Rows as a table in Markdown.

    >>> print(markdown([stated("force", 1.5, "N")]))
    | what | here | target | met |
    | --- | --- | --- | --- |
    | force | 1.5 N | - | - |
    """
    words = {True: "yes", False: "NO", None: "-"}
    lines = [
        f"| {row['name']} | {row['value']:.3g} {row['unit']} | {row['target'] or '-'} "
        f"| {words[row['met']]} |"
        for row in rows
    ]
    return "\n".join(["| what | here | target | met |", "| --- | --- | --- | --- |", *lines])


if __name__ == "__main__":
    command_line("bench.cosserat_rod", __doc__).parse_args()
    print(markdown(run()))
