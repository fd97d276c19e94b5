"""Runs a plan of co-design: every arm with every seed, the best of each held out, and what it says.

Everything is a line of `results.jsonl` in a folder of its own, from which it goes on.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from scipy import stats

from grasp_strategies.search.codesign.halving import Tried, best_of, lines_of, search_by_halving
from grasp_strategies.search.codesign.plan import Plan
from grasp_strategies.search.problem import Evaluation
from grasp_strategies.sweep.cluster import Cluster
from grasp_strategies.sweep.pool import Processes
from grasp_strategies.sweep.results import NAME, Results, read_results
from softhand_model.documents.output_file import write_json

FORMAT = "softhand-codesign-result/1"
RESULT = "codesign.json"
BOTH, SINGLE, SHIPPED = "both", ("motion", "hand"), "shipped"
HELD_OUT = "held_out"
CONFIDENCE = 0.95
HOUR = 3600.0


@dataclass(frozen=True)
class Winner:
    """The best of an arm with a seed: its values, training and held-out success [-], and the trials
    and candidates that the arm took.
    """

    arm: str
    seed: int
    values: Mapping[str, float]
    training: float
    held_out: float
    trials: int
    candidates: int
    infeasible: int


def run_plan(crew: Processes | Cluster, plan: Plan, folder: Path) -> dict[str, Any]:
    """Run what is left of a plan; its result as plain data, which is also written as JSON."""
    found = {
        (arm, seed): search_by_halving(
            crew, plan.problem(arm, seed), plan.halving, folder / f"{arm}_{seed}"
        )
        for arm in plan.arms
        for seed in plan.seeds
    }
    bests = {key: best_of(tried) for key, tried in found.items()}
    held_out = _hold_out(crew, plan, bests, folder / HELD_OUT)
    winners = [
        Winner(
            *key,
            dict(bests[key].values),
            success_of(bests[key].successes),
            held_out[key],
            sum(one.trials for one in tried),
            len(tried),
            sum(bool(one.infeasible) for one in tried),
        )
        for key, tried in found.items()
    ]
    content = {
        "format": FORMAT,
        "plan": plan.name,
        "budget": plan.halving.budget,
        "shipped": held_out[SHIPPED, 0],
        "trials_per_core_hour": trials_per_core_hour(folder),
        "winners": [vars(winner) for winner in winners],
        "gain": gain_of(winners),
    }
    write_json(folder / RESULT, content, force=True)
    return content


def _hold_out(
    crew: Processes | Cluster, plan: Plan, bests: Mapping[tuple[str, int], Tried], folder: Path
) -> dict[tuple[str, int], float]:
    """Held-out success [-] of the best of each arm and seed, and of the shipped pair."""
    values = {key: dict(best.values) for key, best in bests.items()} | {(SHIPPED, 0): {}}
    lines = {key: _held_out_lines(plan, *key, one) for key, one in values.items()}
    with Results(folder) as results:
        everything = [line for some in lines.values() for line in some]
        for record in crew.run(results.left(everything, again=False)):
            results.append(record)
        records = {key: [results.records[line.key] for line in some] for key, some in lines.items()}
    return {
        key: success_of(
            {name: won for record in some for name, won in record.get("successes", {}).items()}
        )
        for key, some in records.items()
    }


def _held_out_lines(
    plan: Plan, arm: str, seed: int, values: Mapping[str, float]
) -> list[Evaluation]:
    """Lines of values at the held-out places; what ends in an error has no success there."""
    any_arm = next(iter(plan.arms))
    problem = replace(
        plan.problem(any_arm, seed), name=f"{arm}_{seed}", settings=dict(plan.held_out)
    )
    return lines_of(Evaluation(problem, 0, values), HELD_OUT, 0, plan.places)


def success_of(successes: Mapping[str, Sequence[int]]) -> float:
    """Mean of the objects' rates of success [-]; 0 where nothing was tried.

    >>> success_of({"ball": [1, 1], "tube": [0, 1]})
    0.75
    """
    return float(np.mean([np.mean(one) for one in successes.values()])) if successes else 0.0


def trials_per_core_hour(folder: Path) -> float:
    """Trials of all lines in a folder's folders over their processor time."""
    records = [one for path in folder.glob(f"*/{NAME}") for one in read_results(path)]
    trials = sum(one.get("trials", 0) for one in records)
    hours = sum(one["cpu_time"] for one in records) / HOUR
    return trials / hours if hours > 0.0 else 0.0


def gain_of(winners: Sequence[Winner]) -> dict[str, Any]:
    """Held-out success of `both` less that of the better single arm, seed by seed, with its
    interval; the better single arm is the one with more held-out success in the mean. Empty where
    an arm is missing.
    """
    by_arm = {arm: _by_seed(winners, arm) for arm in (BOTH, *SINGLE)}
    if not all(by_arm.values()):
        return {}
    best = max(SINGLE, key=lambda arm: float(np.mean(list(by_arm[arm].values()))))
    gains = [by_arm[BOTH][seed] - by_arm[best][seed] for seed in sorted(by_arm[BOTH])]
    low, high = interval(gains)
    return {"against": best, "mean": float(np.mean(gains)), "low": low, "high": high}


def _by_seed(winners: Sequence[Winner], arm: str) -> dict[int, float]:
    return {winner.seed: winner.held_out for winner in winners if winner.arm == arm}


def interval(values: Sequence[float]) -> tuple[float, float]:
    """The 95 % interval of a mean by Student's t; everything for one value.

    >>> [round(end, 3) for end in interval([0.4, 0.5, 0.6])]
    [0.252, 0.748]
    """
    if len(values) < 2:
        return -np.inf, np.inf
    mean, error = float(np.mean(values)), float(stats.sem(values))
    reach = error * float(stats.t.ppf((1.0 + CONFIDENCE) / 2.0, len(values) - 1))
    return mean - reach, mean + reach


def verdict(gain: Mapping[str, Any]) -> str:
    """The sentence that the criteria ask for.

    >>> verdict({"against": "motion", "mean": 0.1, "low": -0.02, "high": 0.22})
    'co-design was not shown to help at this budget: +10.0 points over motion, -2.0 to 22.0'
    """
    if not gain:
        return "co-design was not judged: an arm is missing"
    found = "helps" if gain["low"] > 0.0 else "was not shown to help at this budget"
    mean, low, high = (100.0 * gain[key] for key in ("mean", "low", "high"))
    return f"co-design {found}: {mean:+.1f} points over {gain['against']}, {low:.1f} to {high:.1f}"
