"""Negative controls: fingers that differ from their design are detected, by requirements and lab.

The lab has the angle of the tip alone, which hardly sees where along the finger a wall is thick:
walls that are exchanged are seen in the curvatures, and stand without a target for the lab.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import Any

import numpy as np

from bench.design.loop import verdict_on
from bench.design.requests import feasible
from bench.design.simulated import from_file, held_against
from bench.row import at_least, stated
from softhand_model.hand.actuator import Actuator
from softhand_model.hand.profile import Profile

TAKES = "two minutes"
COUNT = 3  # requests
MODULUS = 0.02  # by which the fitted modulus may be off the design's
WITHIN = 0.02  # of the requirements
THICKER, STIFFER = 1.15, 1.12
EXCHANGED = "walls of base and tip exchanged"


def run(seed: int = 0) -> list[dict[str, Any]]:
    """Rows of the group."""
    return list(_rows(seed))


def _rows(seed: int) -> Iterator[dict[str, Any]]:
    for name, change in CHANGES.items():
        told, off = 0, 0
        for k, design in enumerate(feasible(COUNT, seed)):
            actuator = change(from_file(design))
            found = verdict_on(design, actuator, seed + k)
            held = held_against(design, actuator)
            print(f"{design.actuator.name}, {name}: {held}, {found}", flush=True)
            told += not (found["adequate"] and abs(found["modulus_scale"] - 1.0) <= MODULUS)
            off += max(held.bend, held.force) > WITHIN
        what = f"negative control, {name}: told by the lab"
        seen = name != EXCHANGED
        yield at_least(what, told, "", COUNT) if seen else stated(what, told, "")
        yield at_least("the same: off the wish by more than 2 %", off, "", COUNT)


def _thicker(actuator: Actuator) -> Actuator:
    return replace(actuator, wall=lambda x: THICKER * actuator.wall(x))


def _exchanged(actuator: Actuator) -> Actuator:
    def mirrored(profile: Profile) -> Profile:
        return lambda x: profile(actuator.length - np.asarray(x))

    return replace(actuator, wall=mirrored(actuator.wall), side_wall=mirrored(actuator.side_wall))


CHANGES: dict[str, Callable[[Actuator], Actuator]] = {
    "a wall 15 % too thick": _thicker,
    "a rubber 12 % stiffer": lambda actuator: actuator.with_modulus(STIFFER),
    EXCHANGED: _exchanged,
}
