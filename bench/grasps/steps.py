"""Whether verdicts depend on the physics step: scattered trials of the maps at 1, 2 and 5 ms.

A trial is left out where a shift of the hand by 3 mm changes its verdict at 5 ms: it lies at a
border of the map.
"""

from __future__ import annotations

import time
from dataclasses import replace
from typing import Any

import numpy as np

from bench.grasps.verdicts import gripped
from bench.row import at_least, stated
from grasp_strategies.sweep import TrialLine
from thesis.chapter_8 import push_map, surface_map
from thesis.chapter_8.object_map import YIELDING, map_plan

COUNT = 200
STEPS = (0.001, 0.002)  # beside that of the maps [s]
NEAR = 0.003  # [m] from a border
SIDES = ((NEAR, 0.0), (-NEAR, 0.0), (0.0, NEAR), (0.0, -NEAR))


def scattered(seed: int, count: int = COUNT) -> list[TrialLine]:
    """Trials of both maps without jitter, drawn from all cells of the rigid headline objects,
    those of one object after each other.
    """
    lines = []
    for module, name, strategy, upright in (
        (push_map, "push_map", "rbo_hand_1_push", push_map.UPRIGHT),
        (surface_map, "surface_map", "rbo_hand_1_surface", ()),
    ):
        rigid = tuple(n for n in module.HEADLINE if n not in YIELDING)
        given = module.Parameters(objects=rigid, replicates=0)
        lines += map_plan(name, strategy, given, upright).lines()
    chosen = np.random.default_rng(seed).choice(len(lines), count, replace=False)
    return [lines[k] for k in sorted(chosen)]


def at_step(line: TrialLine, step: float) -> TrialLine:
    """The same trial at another step [s]."""
    settings = replace(line.settings, step=step)
    return replace(line, key=f"{line.key}/{step:g}", settings=settings)


def beside(line: TrialLine, side: tuple[float, float]) -> TrialLine:
    """The same trial with the object shifted [m]."""
    x, y = (a + b for a, b in zip(line.placement.offset, side, strict=True))
    placement = replace(line.placement, offset=(x, y))
    return replace(line, key=f"{line.key}/{side[0]:g},{side[1]:g}", placement=placement)


def run(seed: int, jobs: int, minutes: float = 120.0, count: int = COUNT) -> list[dict[str, Any]]:
    """Share of the trials off the borders whose verdicts agree at all steps."""
    lines, end = scattered(seed, count), time.monotonic() + 60 * minutes
    own = gripped("steps", lines, jobs, end)
    sides = gripped("steps-beside", [beside(a, side) for a in lines for side in SIDES], jobs, end)
    judged = [
        line for line in lines if all(sides[beside(line, s).key] == own[line.key] for s in SIDES)
    ]
    found = {
        step: gripped(f"steps-{1e3 * step:g}ms", [at_step(a, step) for a in lines], jobs, end)
        for step in STEPS
    }
    agreed = sum(
        all(found[step][at_step(line, step).key] == own[line.key] for step in STEPS)
        for line in judged
    )
    what = f"verdicts at 1, 2 and 5 ms agree, of {len(judged)} trials"
    return [
        stated("scattered trials at a border, left out", count - len(judged), ""),
        at_least(what, 100 * agreed / len(judged), "%", 95),
    ]
