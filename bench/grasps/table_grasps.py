"""RBO Hand 2 from the table: cylinder, tube, bottle and ball in twenty jittered places each."""

from __future__ import annotations

import tempfile
from dataclasses import replace
from typing import Any

from bench.row import at_least
from grasp_strategies.judging.judge import GRIPPED
from grasp_strategies.strategy import load_strategy
from grasp_strategies.strategy.fitting import fitting_strategies
from grasp_strategies.sweep import Jitter, SweepPlan, run_sweep
from grasp_strategies.sweep.plan import SweptObject
from grasp_strategies.trials import TrialSettings

HAND, OBJECTS = "rbo_hand_2", ("cylinder", "tube", "water_bottle", "ball")
PLACES, SPREAD = 20, 0.010  # places an object, largest shift in x and y [m]
FIRST_SEED = 100  # no strategy was tuned on what it draws


def run(seed: int, jobs: int) -> list[dict[str, Any]]:
    """Share of the places from which each object is lifted."""
    rows = []
    for name in OBJECTS:
        plan = SweepPlan(
            f"table-{name}",
            TrialSettings(strategy_for(name), step=0.002, early_end=True),
            (SweptObject(name),),
            replicates=PLACES,
            seed=FIRST_SEED + seed,
            jitter=replace(Jitter(), place=SPREAD),
        )
        with tempfile.TemporaryDirectory() as folder:
            records = run_sweep(plan, folder, jobs)
        held = sum(record.get("outcome") == GRIPPED for record in records)
        what = f"{name} from the table with {plan.settings.strategy}, {PLACES} places: lifted"
        rows.append(at_least(what, 100 * held / PLACES, "%", 90))
    return rows


def strategy_for(name: str) -> str:
    """The first shipped strategy of the hand that lifts an object from the table.

    Raises:
        ValueError: there is none.
    """
    for strategy in fitting_strategies(name, HAND):
        if load_strategy(strategy).tried_with.scene == "table":
            return strategy
    raise ValueError(f"{name}: expected a strategy of {HAND} from the table, got none")
