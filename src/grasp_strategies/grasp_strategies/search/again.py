"""The best evaluations of a search, tried again with jitter: what is best once may be best by luck,
and an experimenter keeps what can be repeated.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

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
    candidates: int,
    folder: Path,
) -> list[Tried]:
    """The `candidates` best evaluations, each once with every draw; the least worst cost first.

    Args:
        crew: who runs them.
        problem: of the search; its objective's setting `draw` says how a try differs.
        result: of the search.
        draws: seeds of the tries, by the end of their keys.
        candidates: how many are tried.
        folder: of the results, from which a run goes on.

    Raises ValueError when all evaluations of the search ended in errors.
    """
    best = result.best_first[:candidates]
    lines = [_try(problem, record, name, draw) for name, draw in draws.items() for record in best]
    with Results(folder) as results:
        for record in crew.run(results.left(lines)):
            results.append(record)
        found = [results.records[line.key] for line in lines]
    tried = [Tried(record, found[rank :: len(best)]) for rank, record in enumerate(best)]
    return sorted(tried, key=lambda one: (one.worst, one.record[COST]))


def _try(problem: SearchProblem, record: Record, name: str, draw: Sequence[int]) -> Evaluation:
    settings: dict[str, Any] = {**problem.settings, "draw": list(draw)}
    again = replace(problem, name=f"{problem.name}_{name}", settings=settings)
    return Evaluation(again, int(record["key"].rpartition("/")[2]), record["values"])
