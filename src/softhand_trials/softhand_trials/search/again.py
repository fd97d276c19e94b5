"""Repetition of the best evaluations of a search with jitter, as the lowest cost may be due to
chance."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from softhand_trials.search.halving import successive_halving
from softhand_trials.search.objective import COST
from softhand_trials.search.problem import Evaluation, SearchProblem
from softhand_trials.search.run import SearchResult
from softhand_trials.sweep.results import Results
from softhand_trials.sweep.run import Workers
from softhand_trials.sweep.task import Record

IN_ERROR = 1e3  # cost of a try that ended in an error


@dataclass(frozen=True)
class Tried:
    """One of the best evaluations of a search, and the records of its repetitions."""

    record: Record
    records: Sequence[Record]

    @property
    def worst(self) -> float:
        """Greatest cost of its repetitions; if there are none, its cost in the search."""
        costs = [record.get(COST, IN_ERROR) for record in self.records]
        return float(max(costs, default=self.record[COST]))


def try_again(
    workers: Workers,
    problem: SearchProblem,
    result: SearchResult,
    draws: Mapping[str, Sequence[int]],
    candidates: Sequence[int],
    folder: Path,
) -> list[Tried]:
    """Run the best evaluations of a search again in rounds, each of them with other draws of
    jitter.

    The first round has the best evaluation of each generation, since the best ones of the last
    generation are nearly equal. Those with the lowest worst cost so far go into the next round.

    Args:
        workers: workers that run the evaluations.
        problem: problem of the search; the setting `draw` of its objective is the seed of the
            jitter.
        result: result of the search.
        draws: seeds `draw` of each round, by the text that ends the keys of the round.
        candidates: number of evaluations in each round, never more than in the round before.
        folder: folder of the results, from which an interrupted run continues.

    Returns:
        All evaluations of the first round, sorted: those that were in most rounds come first, and
        among these the ones with the lowest worst cost.

    Raises ValueError when all evaluations of the search ended in errors.
    """
    first = result.best_of_generations(problem.generation)[: candidates[0]]
    rounds = list(draws.items())

    def tasks(k: int, number: int) -> list[Evaluation]:
        """The repetition of a candidate in a round."""
        return [_try(problem, first[k], *rounds[number])]

    def rank(k: int, records: Sequence[Record]) -> tuple[float, float]:
        """Its worst cost so far, then that in the search."""
        return Tried(first[k], records).worst, first[k][COST]

    with Results(folder, result=COST, needed=("values",)) as results:
        counts = [min(count, len(first)) for count in candidates]
        order, records = successive_halving(workers, results, counts, tasks, rank)
    return [Tried(first[k], records[k]) for k in order]


def _try(problem: SearchProblem, record: Record, name: str, draw: Sequence[int]) -> Evaluation:
    again = replace(problem.with_settings(draw=list(draw)), name=f"{problem.name}_{name}")
    return Evaluation(again, int(record["key"].rpartition("/")[2]), record["values"])
