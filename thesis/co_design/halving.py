"""One search: generations of designs, of which the better ones are tried more often.

A sampler of the searches is asked for designs; those that cannot be built or cast cost no trial,
and others are asked for in their place. Every trial is a line of `results.jsonl`, from which a
search goes on; the sampler is told in order when a generation is done, so the same search tries the
same designs on any number of workers.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from grasp_strategies.search import SearchProblem
from grasp_strategies.search.study import Study
from grasp_strategies.sweep.cluster import Cluster
from grasp_strategies.sweep.line import Line, Record
from grasp_strategies.sweep.pool import Processes
from grasp_strategies.sweep.results import Results
from thesis.co_design.arms import Arm
from thesis.co_design.hands import broken
from thesis.co_design.plan import Plan
from thesis.co_design.trials import SHIPPED, Design, design_of
from thesis.co_design.worlds import HIGHEST, score, trials_of

Crew = Processes | Cluster
MakeTrials = Callable[[str, Design, Sequence[int]], Sequence[Line]]
OBJECTIVE = "thesis.co_design:trials"  # names a search; it is not run as one of `softhand search`
SPREAD = 0.08  # of designs around the shipped pair, after the first generation: share of a range
MOST_ASKED = 1_000_000


@dataclass(frozen=True)
class Tried:
    """A design with the score that its search was told, and how many trials that is of; `spent`:
    trials of the search up to its generation's end; `design`: as it was given, by number.
    """

    number: int
    values: Mapping[str, float]
    score: float
    trials: int
    spent: int


def run_search(
    crew: Crew,
    arm: Arm,
    seed: int,
    plan: Plan,
    folder: Path,
    make_trials: MakeTrials | None = None,
) -> list[Tried]:
    """All designs of a search, in the order in which they were asked for.

    Args:
        crew: who runs trials.
        arm: what is searched, and how.
        seed: of sampler and world.
        plan: budget and world.
        folder: of its results.
        make_trials: trials of a design by the first part of their keys and their numbers; those of
            the plan's training by default.
    """
    make = make_trials or (
        lambda key, design, numbers: trials_of(key, design, plan.training, seed, numbers)
    )
    study, tried = Study(_problem(arm, seed, plan)), list[Tried]()
    with Results(folder) as results:
        for _ in range(plan.generations):
            generation = _feasible(study, arm, plan.generation)
            if arm.labels == "noise":
                found = _noise(generation, seed)
            else:
                found = _halved(crew, arm, seed, plan, generation, results, make)
            if arm.labels == "shuffled":
                order = np.random.default_rng([seed, generation[0][0]]).permutation(len(found))
                found = [found[k] for k in order]
            spent = (tried[-1].spent if tried else 0) + sum(count for _, count in found)
            for (number, values), (label, count) in zip(generation, found, strict=True):
                study.tell_cost(number, -(label + count))  # by trials first, as they were kept
                tried.append(Tried(number, values, label, count, spent))
    return tried


def _problem(arm: Arm, seed: int, plan: Plan) -> SearchProblem:
    return SearchProblem(
        f"{arm.name}-{seed}",
        OBJECTIVE,
        arm.variables,
        MOST_ASKED,
        plan.generation,
        arm.sampler,
        seed,
        {variable.name: SHIPPED[variable.name] for variable in arm.variables},
        spread=SPREAD if arm.sampler == "cma" else None,
    )


def _feasible(study: Study, arm: Arm, count: int) -> list[tuple[int, dict[str, float]]]:
    """The next designs that can be built and cast, by number; others are told as failed."""
    found: list[tuple[int, dict[str, float]]] = []
    while len(found) < count:
        for asked in study.ask(count - len(found)):
            if arm.free_hand and broken(SHIPPED | dict(asked.values)):
                study.tell_cost(asked.number, None)
            else:
                found.append((asked.number, dict(asked.values)))
    return found


def _noise(generation: Sequence[tuple[int, Any]], seed: int) -> list[tuple[float, int]]:
    """Scores that say nothing, without a trial; each counts as that of a whole course."""
    draws = [np.random.default_rng([seed, number]) for number, _ in generation]
    return [(float(draw.uniform(0.0, HIGHEST)), 0) for draw in draws]


def _halved(
    crew: Crew,
    arm: Arm,
    seed: int,
    plan: Plan,
    generation: Sequence[tuple[int, Mapping[str, float]]],
    results: Results,
    make: MakeTrials,
) -> list[tuple[float, int]]:
    """Scores of a generation's designs and how many trials they are of."""
    left, begun = list(range(len(generation))), 0
    records: list[list[Record]] = [[] for _ in generation]
    for rung, kept in zip(plan.rungs, (*plan.kept, 0), strict=True):
        numbers = range(begun, rung)
        lines = {
            k: make(_key(arm, seed, generation[k][0]), design_of(generation[k][1]), numbers)
            for k in left
        }
        finish(crew, [line for some in lines.values() for line in some], results)
        for k, some in lines.items():
            records[k] += [results.records[line.key] for line in some]
        left = sorted(left, key=lambda k: (-score(records[k]), k))[:kept]
        begun = rung
    return [(score(some), len(some)) for some in records]


def _key(arm: Arm, seed: int, number: int) -> str:
    return f"{arm.name}-{seed}/{number:04d}"


def finish(crew: Crew, lines: Sequence[Line], results: Results) -> list[Record]:
    """Run what has no result yet; the records of all of them. An error stays one when the run is
    started again: what the search asked for next followed from it.
    """
    for record in crew.run(results.left(lines, again=False)):
        results.append(record)
    return [results.records[line.key] for line in lines]


def best_first(tried: Iterable[Tried], most: int) -> list[Tried]:
    """Designs whose score is of `most` trials, or of noise, the best first."""
    whole = [one for one in tried if one.trials in (0, most)]
    return sorted(whole, key=lambda one: (-one.score, one.number))


def course(tried: Iterable[Tried], most: int) -> list[tuple[int, float]]:
    """Trials spent, and the best score of a whole course by then."""
    found: dict[int, float] = {}
    best = -np.inf
    for one in tried:
        if one.trials == most:
            best = max(best, one.score)
        found[one.spent] = float(best)
    return list(found.items())
