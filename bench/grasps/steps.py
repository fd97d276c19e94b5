"""Whether verdicts depend on the physics step: scattered trials of the maps at 1, 2 and 5 ms.

A trial is left out where a shift of the hand by 3 mm changes its verdict at 5 ms: it lies at a
border of the map.
"""

from __future__ import annotations

import time
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from bench.grasps.verdicts import OUT, gripped
from bench.row import at_least, stated
from softhand_trials.sweep import SweepPlan, TrialTask
from thesis.chapter_8 import push_map, surface_map
from thesis.chapter_8.object_map import YIELDING, MapParameters, map_plan
from thesis.chapter_9 import edge_map

TAKES = "half an hour"
COUNT = 200
OF_OBJECTS = ("push_map", "surface_map")  # the maps of chapter 8
ALL = (*OF_OBJECTS, "edge_map")
STEPS = (0.001, 0.002)  # beside that of the maps [s]
NEAR = 0.003  # [m] from a border
SIDES = ((NEAR, 0.0), (-NEAR, 0.0), (0.0, NEAR), (0.0, -NEAR))


def plan_of(name: str) -> SweepPlan:
    """Trials that are drawn from a map: each cell of the rigid headline objects without jitter, of
    the edge, where there are fewer cells, also the jittered ones.
    """
    if name == "edge_map":
        return replace(edge_map.plan(edge_map.Parameters(), Path(OUT)), nominal=True)
    if name == "push_map":
        return map_plan(name, "rbo_hand_1_push", _rigid(push_map.HEADLINE), push_map.UPRIGHT)
    return map_plan(name, "rbo_hand_1_surface", _rigid(surface_map.HEADLINE))


def _rigid(headline: tuple[str, ...]) -> MapParameters:
    return MapParameters(objects=tuple(n for n in headline if n not in YIELDING), replicates=0)


def scattered(seed: int, count: int = COUNT, names: tuple[str, ...] = ALL) -> list[TrialTask]:
    """Trials drawn from these maps, as many from each, those of one hand and object after each
    other.
    """
    found = []
    for number, name in enumerate(names):
        lines = plan_of(name).tasks()
        share = (count + number) // len(names)
        chosen = np.random.default_rng([seed, number]).choice(len(lines), share, replace=False)
        found += [lines[k] for k in sorted(chosen)]
    return found


def at_step(line: TrialTask, step: float) -> TrialTask:
    """The same trial at another step [s]."""
    settings = replace(line.settings, step=step)
    return replace(line, key=f"{line.key}/{step:g}", settings=settings)


def beside(line: TrialTask, side: tuple[float, float]) -> TrialTask:
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
