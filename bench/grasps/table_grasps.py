"""RBO Hand 2 from the table: cylinder, tube, bottle and ball in twenty jittered places each."""

from __future__ import annotations

import tempfile
from dataclasses import replace
from typing import Any

from bench.row import at_least, at_most
from grasp_strategies.judging.judge import OUTCOME_GRIPPED
from grasp_strategies.strategy import load_strategy
from grasp_strategies.strategy.fitting import fitting_strategies
from softhand_trials.sweep import Jitter, SweepPlan, run_sweep
from softhand_trials.sweep.plan import SweptObject
from softhand_trials.sweep.success_map import finished
from softhand_trials.trials import TrialSettings

TAKES = "10 min"
HAND, OBJECTS = "rbo_hand_2", ("cylinder", "tube", "water_bottle", "ball")
PLACES, SPREAD = 20, 0.010  # places an object, largest shift in x and y [m]
CONTROLS = 3  # places without air
FIRST_SEED = 100  # no strategy was tuned on what it draws


def run(seed: int, jobs: int) -> list[dict[str, Any]]:
    """Share of the places from which each object is lifted, and how many are without air."""
    rows = []
    for name in OBJECTS:
        plan = plan_of(name, FIRST_SEED + seed)
        what = f"{name} from the table with {plan.settings.strategy}"
        share = 100 * lifted(plan, jobs) / PLACES
        rows.append(at_least(f"{what}, {PLACES} places: lifted", share, "%", 90))
        empty = replace(plan.settings, air_scale=0.0)
        control = lifted(replace(plan, settings=empty, replicates=CONTROLS), jobs)
        rows.append(at_most(f"{what}: negative control, 0 kPa: lifted", control, "", 0))
    return rows


def plan_of(name: str, seed: int) -> SweepPlan:
    """The jittered places of an object."""
    return SweepPlan(
        f"table-{name}",
        TrialSettings(strategy_for(name), step=0.002, early_end=True),
        (SweptObject(name),),
        replicates=PLACES,
        seed=seed,
        jitter=replace(Jitter(), place=SPREAD),
    )


def lifted(plan: SweepPlan, jobs: int) -> int:
    """How many trials of a plan succeed; raises RuntimeError where one has no verdict."""
    with tempfile.TemporaryDirectory() as folder:
        records = finished(run_sweep(plan, folder, jobs))
    return sum(record["outcome"] == OUTCOME_GRIPPED for record in records)


def strategy_for(name: str) -> str:
    """The first shipped strategy of the hand that lifts an object from the table.

    Raises:
        ValueError: there is none.
    """
    for strategy in fitting_strategies(name, HAND):
        if load_strategy(strategy).tried_with.scene == "table":
            return strategy
    raise ValueError(f"{name}: expected a strategy of {HAND} from the table, got none")
