"""One search: generations of designs, with successive halving, which tries the better ones more
often.

A sampler proposes designs. Those that cannot be built or cast cost no trial; others are proposed in
their place. Every trial is a record in `results.jsonl`, from which an interrupted search goes on.
The sampler gets the scores in order when a generation is done, so a search tries the same designs
on any number of workers.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from softhand_trials.search import SearchProblem
from softhand_trials.search.halving import successive_halving
from softhand_trials.search.study import Study
from softhand_trials.sweep.results import Results
from softhand_trials.sweep.run import Workers
from softhand_trials.sweep.task import Record, Task
from thesis.co_design.arms import Arm
from thesis.co_design.hands import broken
from thesis.co_design.plan import Plan
from thesis.co_design.trials import SHIPPED, Design, design_of
from thesis.co_design.worlds import HIGHEST, score, trials_of

MakeTrials = Callable[[str, Design, Sequence[int]], Sequence[Task]]
OBJECTIVE = "thesis.co_design:trials"  # names a search; it is not run as one of `softhand search`
SPREAD = 0.08  # of designs around the shipped pair, after the first generation: share of a range
MOST_ASKED = 1_000_000


@dataclass(frozen=True)
class Tried:
    """A design with the score that its search was given, and the number of trials in it. `spent`:
    trials of the search up to the end of the design's generation; `design`: its numbers, by the
    number of the proposal.
    """

    number: int
    values: Mapping[str, float]
    score: float
    trials: int
    spent: int


def run_search(
    workers: Workers,
    arm: Arm,
    seed: int,
    plan: Plan,
    folder: Path,
    make_trials: MakeTrials | None = None,
) -> list[Tried]:
    """All designs of a search, in the order in which they were proposed.

    Args:
        workers: who runs trials.
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
                found = _halved(workers, arm, seed, plan, generation, results, make)
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
        allow_any=True,
    )


def _feasible(study: Study, arm: Arm, count: int) -> list[tuple[int, dict[str, float]]]:
    """The next designs that can be built and cast, by number; the others are reported to the
    sampler as failed.
    """
    found: list[tuple[int, dict[str, float]]] = []
    while len(found) < count:
        for asked in study.ask(count - len(found)):
            if arm.free_hand and broken(SHIPPED | dict(asked.values)):
                study.tell_cost(asked.number, None)
            else:
                found.append((asked.number, dict(asked.values)))
    return found


def _noise(generation: Sequence[tuple[int, Any]], seed: int) -> list[tuple[float, int]]:
    """Random scores without trials; each counts as that of all trials of a design."""
    draws = [np.random.default_rng([seed, number]) for number, _ in generation]
    return [(float(draw.uniform(0.0, HIGHEST)), 0) for draw in draws]


def _halved(
    workers: Workers,
    arm: Arm,
    seed: int,
    plan: Plan,
    generation: Sequence[tuple[int, Mapping[str, float]]],
    results: Results,
    make: MakeTrials,
) -> list[tuple[float, int]]:
    """Scores of a generation's designs and how many trials they are of."""
    rungs = [0, *plan.rungs]

    def tasks(k: int, number: int) -> Sequence[Task]:
        """Trials that a design has in a round."""
        asked, values = generation[k]
        numbers = range(rungs[number], rungs[number + 1])
        return make(_key(arm, seed, asked), design_of(values), numbers)

    def rank(k: int, records: Sequence[Record]) -> tuple[float, int]:
        """The best score first, then the one asked for first."""
        return -score(records), k

    # an error stays one: what the search asked for next followed from it
    counts = (len(generation), *plan.kept)
    _, records = successive_halving(workers, results, counts, tasks, rank, again=False)
    return [(score(some), len(some)) for some in records]


def _key(arm: Arm, seed: int, number: int) -> str:
    return f"{arm.name}-{seed}/{number:04d}"


def best_first(tried: Iterable[Tried], most: int) -> list[Tried]:
    """Designs whose score is of `most` trials, or is noise, best first."""
    whole = [one for one in tried if one.trials in (0, most)]
    return sorted(whole, key=lambda one: (-one.score, one.number))


def learning_curve(tried: Iterable[Tried], most: int) -> list[tuple[int, float]]:
    """Trials spent, and the best score of a fully tried design up to then."""
    found: dict[int, float] = {}
    best = -np.inf
    for one in tried:
        if one.trials == most:
            best = max(best, one.score)
        found[one.spent] = float(best)
    return list(found.items())
