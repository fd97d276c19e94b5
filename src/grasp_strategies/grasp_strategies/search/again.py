"""The best evaluations of a search, tried again with jitter: what is best once may be best by luck,
and an experimenter keeps what can be repeated.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from grasp_strategies.search.objective import COST
from grasp_strategies.search.problem import Evaluation, SearchProblem
from grasp_strategies.search.run import SearchResult
from grasp_strategies.sweep.cluster import Cluster
from grasp_strategies.sweep.line import Record
from grasp_strategies.sweep.pool import Processes
from grasp_strategies.sweep.results import Results

IN_ERROR = 1e3  # cost of a try that ended in an error


@dataclass(frozen=True)
class Tried:
    """One of the best evaluations of a search, and its records when it was tried again."""

    record: Record
    records: Sequence[Record]

    @property
    def worst(self) -> float:
        """Its greatest cost; that of the search when it was not tried again."""
        costs = [record.get(COST, IN_ERROR) for record in self.records]
        return float(max(costs, default=self.record[COST]))


def try_again(
    crew: Processes | Cluster,
    problem: SearchProblem,
    result: SearchResult,
    draws: Mapping[str, Sequence[int]],
    candidates: Sequence[int],
    folder: Path,
) -> list[Tried]:
    """Try the best of a search in rounds, each with a draw that is new; the winner comes first.

    The first round has the best of each generation, at most one of each, since the latest best are
    nearly the same. Into a later round goes what has the least worst cost so far, as in successive
    halving (Jamieson and Talwalkar, AISTATS 2016).

    Args:
        crew: who runs them.
        problem: of the search; its objective's setting `draw` says how a try differs.
        result: of the search.
        draws: seeds of the rounds, by the end of their keys.
        candidates: how many are in each round, never more than in the one before.
        folder: of the results, from which a run goes on.

    Returns:
        All of the first round, those tried most often first, of these the least worst cost.

    Raises ValueError when all evaluations of the search ended in errors.
    """
    first = result.best_of_generations(problem.generation)[: candidates[0]]
    tried = [Tried(record, []) for record in first]
    with Results(folder) as results:
        for (name, draw), count in zip(draws.items(), candidates, strict=True):
            lines = [_try(problem, one.record, name, draw) for one in tried[:count]]
            for record in crew.run(results.left(lines)):
                results.append(record)
            again = [
                Tried(one.record, [*one.records, results.records[line.key]])
                for one, line in zip(tried, lines, strict=False)
            ]
            again.sort(key=lambda one: (one.worst, one.record[COST]))
            tried = again + tried[len(again) :]
    return tried


def _try(problem: SearchProblem, record: Record, name: str, draw: Sequence[int]) -> Evaluation:
    again = replace(problem.with_settings(draw=list(draw)), name=f"{problem.name}_{name}")
    return Evaluation(again, int(record["key"].rpartition("/")[2]), record["values"])
