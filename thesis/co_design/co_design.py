"""Co-design: hand and motion searched together, against either alone (5.1, 6.5, 9.2, 10.2).

The thesis argues that body and motion should be improved together, but does not do it. Here three
arms have equal numbers of trials: motions for the shipped hand, hands for the shipped motion, and
both. They are compared with random search, the shipped pair, and two negative controls, which get
shuffled scores and noise. `plan.py`, written before any run, defines what is run and how it is
judged. A run that is started again goes on; a killed one loses no finished trial.
"""

from __future__ import annotations

import time
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, Self

import numpy as np

from softhand_trials.sweep.results import RESULTS_FILE, read_results
from softhand_trials.sweep.results import Results as ResultLines
from softhand_trials.sweep.run import start_workers
from softhand_trials.sweep.task import Record
from thesis.co_design import figure as pictures
from thesis.co_design.arms import ARMS, CO_DESIGN, NOISE, SHUFFLED, Arm
from thesis.co_design.findings import BEST, SHIPPED_PAIR, findings, shares_of
from thesis.co_design.halving import Tried, Workers, learning_curve, run_search
from thesis.co_design.judged import (
    best_designs,
    broke,
    fine_held_out,
    fine_scores,
    first_castable,
    judge,
    postures,
    refusals,
)
from thesis.co_design.plan import PLANS, Plan
from thesis.co_design.statistics import sentence
from thesis.co_design.trials import HAND, SHIPPED, Physics, design_of, write_design
from thesis.frame import Figure, Job, Report, Results, option

SIZE = (11.0, 8.5)
SMALL = {"plan": "small"}


@dataclass(frozen=True)
class Parameters:
    """Options of the experiment."""

    plan: str = option("night", "budget, seeds, worlds: night (two cores, 2 h) or small [-]")
    jobs: int = option(2, "processes [-]")
    scheduler: str = option("", "address of a Dask scheduler instead, as tls://node:8786 [-]")

    def __post_init__(self) -> None:
        if self.plan not in PLANS:
            raise ValueError(f"plan: expected one of {', '.join(PLANS)}, got {self.plan}")

    def continued(self, folder: Path) -> Self:
        """The same parameters. A run goes on with the results in its folder, and refuses those of
        another plan.
        """
        return self


def run(given: Parameters, job: Job) -> Results:
    """All searches, the evaluation of their winners, and the best one at the fine step."""
    return run_plan(PLANS[given.plan], job, given.jobs, given.scheduler or None)


def run_plan(plan: Plan, job: Job, jobs: int = 2, scheduler: str | None = None) -> Results:
    """The same for any plan."""
    begin, before = time.monotonic(), sum(1 for _ in _lines(job.folder))
    with (
        start_workers(jobs, scheduler) as workers,
        ResultLines(job.folder / "judged") as judged,
    ):
        searches, kept = {}, {}
        schedule = list(_schedule(plan))
        for count, (arm, seed) in enumerate(schedule):
            job.progress(f"{arm.name}, seed {seed}", 0.9 * count / len(schedule))
            name = f"{arm.name}-{seed}"
            tried = run_search(workers, arm, seed, plan, job.folder / "searches" / name)
            kept[name] = tried
            searches[name] = _searched(workers, arm, seed, plan, tried, judged, job.folder)
        job.progress("the shipped pair", 0.9)
        shipped = design_of({})
        pair = [judge(workers, f"{SHIPPED_PAIR}-{s}", shipped, s, plan, judged) for s in plan.seeds]
        job.progress("the fine step", 0.92)
        results = {
            "plan": asdict(plan),
            "budget": plan.budget,
            "searches": searches,
            SHIPPED_PAIR: pair,
            **_confirmed(workers, searches, kept, plan, judged, job.folder),
        }
    spent = time.monotonic() - begin
    results["cost"] = _cost(list(_lines(job.folder)), before, spent, jobs)
    return results


def _schedule(plan: Plan) -> Iterator[tuple[Arm, int]]:
    """Searches in the order of seeds, so that an interrupted run has all arms of its finished
    seeds.
    """
    for seed in plan.seeds:
        yield from ((arm, seed) for arm in (*ARMS, NOISE))
        if seed in plan.control_seeds:
            yield SHUFFLED, seed


def _searched(
    workers: Workers,
    arm: Arm,
    seed: int,
    plan: Plan,
    tried: Sequence[Tried],
    judged: ResultLines,
    folder: Path,
) -> dict[str, Any]:
    """A search as plain data: its winner, with the winner's evaluation."""
    name = f"{arm.name}-{seed}"
    winner, refused = first_castable(tried, plan.rungs[-1], folder / "winners" / name)
    design = design_of(winner.values)
    return {
        "arm": arm.name,
        "seed": seed,
        "trials": tried[-1].spent,
        "designs": len(tried),
        "infeasible": tried[-1].number + 1 - len(tried),
        "course": learning_curve(tried, plan.rungs[-1]),
        "winner": dict(design),
        "number": winner.number,
        "told": winner.score,
        "refused": refused,
        **judge(workers, name, design, seed, plan, judged),
    }


def _confirmed(
    workers: Workers,
    searches: Mapping[str, Any],
    kept: Mapping[str, Sequence[Tried]],
    plan: Plan,
    judged: ResultLines,
    folder: Path,
) -> dict[str, Any]:
    """The best hand of the co-design arm by its training: its moulds, and its trials at the fine
    step.
    """
    of_arm = {name: one for name, one in searches.items() if one["arm"] == CO_DESIGN.name}
    best = max(of_arm, key=lambda name: of_arm[name]["told"])
    seed, design = of_arm[best]["seed"], design_of(of_arm[best]["winner"])
    write_design(dict(design), folder / BEST)
    write_design(SHIPPED, folder / SHIPPED_PAIR)
    pairs = {BEST: design, SHIPPED_PAIR: design_of({})}
    return {
        BEST: best,
        "moulds": refusals(folder / BEST / HAND),
        "postures": {name: postures(folder / name / HAND) for name in pairs},
        "ranked": fine_scores(workers, best_designs(kept[best], plan), seed, plan, judged),
        "fine": fine_held_out(workers, pairs, seed, plan, judged),
    }


def _lines(folder: Path) -> Iterator[Record]:
    for path in sorted(folder.rglob(RESULTS_FILE)):
        yield from read_results(path)


def _cost(records: Sequence[Record], before: int, spent: float, jobs: int) -> dict[str, float]:
    """Times of trials: of the processor [s] for coarse and fine ones, and of this run."""
    times: dict[bool, list[float]] = {True: [], False: []}
    for record in records:
        coarse = record["physics"]["step"] >= Physics().step
        if "cpu_time" in record:  # not where its worker was lost
            times[coarse].append(record["cpu_time"])
    found = {
        "trials": len(records),
        "broken": sum(map(broke, records)),
        "cpu_time": float(np.mean(times[True])),
        "fine_cpu_time": float(np.mean(times[False])) if times[False] else 0.0,
        "cpu_hours": sum(map(sum, times.values())) / 3600.0,
    }
    if len(records) > before:
        found |= {"wall_time": spent, "run": len(records) - before, "jobs": jobs}
    return found


# ---------------------------------------------------------------- report
def report(results: Results, given: Parameters) -> Report:
    """Trials spent, success of each arm, comparisons, confirmations, controls."""
    return Report(list(findings(results)), sentence(shares_of(results), results["budget"]))


# ---------------------------------------------------------------- figure
def draw(figure: Figure, results: Results, report: Report) -> None:
    """Learning curves, held-out success with intervals, shipped and best hand side by side."""
    top, below = figure.subfigures(2, 1, height_ratios=(1.0, 1.15))  # type: ignore[misc]
    left, right = top.subplots(1, 2)
    pictures.draw_courses(left, results)
    pictures.draw_shares(right, shares_of(results))
    values = results["searches"][results[BEST]]["winner"]
    pictures.draw_hands(below, {SHIPPED_PAIR: SHIPPED, BEST: values})
