"""Runs a search generation by generation, on the workers of the sweeps. Each evaluation is a line
of `results.jsonl`; a search that was stopped continues from there.
"""

from __future__ import annotations

import json
import sys
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from softhand_common.documents.output_file import UnwritableFile, write_file
from softhand_common.progress import Progress
from softhand_trials.search.objective import COST
from softhand_trials.search.problem import SearchProblem
from softhand_trials.search.study import Study
from softhand_trials.sweep.results import Results
from softhand_trials.sweep.run import Workers, pace, start_workers
from softhand_trials.sweep.task import Record

BEST, BEST_FORMAT = "best.json", "softhand-search-best/1"


@dataclass(frozen=True)
class SearchResult:
    """All evaluations of a search, in the order in which they were asked for."""

    records: Sequence[Record]

    @property
    def best_first(self) -> list[Record]:
        """Evaluations that did not end in an error, the least cost first, those of equal cost in
        the order in which they were asked for; raises ValueError when there are none.
        """
        valid = [record for record in self.records if "error" not in record]
        if not valid:
            raise ValueError(f"all evaluations ended in errors: {self.records[0]['error']}")
        return sorted(valid, key=lambda record: float(record[COST]))

    def best_of_generations(self, generation: int) -> list[Record]:
        """The best evaluation of each generation, the least cost first; `generation` is the number
        of evaluations in each.
        """
        place = {record["key"]: number for number, record in enumerate(self.records)}
        best: dict[int, Record] = {}
        for record in self.best_first:
            best.setdefault(place[record["key"]] // generation, record)
        return list(best.values())

    @property
    def best(self) -> Record:
        """The evaluation of the least cost."""
        return self.best_first[0]

    @property
    def values(self) -> Mapping[str, float]:
        """Values of the variables in the best evaluation."""
        return dict(self.best["values"])

    @property
    def failed(self) -> int:
        """Number of evaluations that ended in an error."""
        return sum("error" in record for record in self.records)

    def least_costs(self) -> list[float | None]:
        """Least cost up to each evaluation; None before the first evaluation that has a cost."""
        least: float | None = None
        found = []
        for record in self.records:
            if "error" not in record and (least is None or record[COST] < least):
                least = float(record[COST])
            found.append(least)
        return found


def run_search(
    problem: SearchProblem, folder: str | Path, jobs: int = 2, scheduler: str | None = None
) -> SearchResult:
    """Run the evaluations of a search that have no result yet; return all its evaluations.

    Args:
        problem: what is searched.
        folder: folder of `results.jsonl`, which is made if missing; `best.json` and `study.log` are
            written there at the end.
        jobs: number of processes; 0: run in this process.
        scheduler: address of a Dask scheduler, such as `tls://node:8786`, instead of processes.

    Raises:
        ValueError: the folder holds results of another problem, or of a search that still runs; or
            a result cannot be written.
        ConnectionError: the scheduler or its workers are not there, or got lost.
    """
    with start_workers(jobs, scheduler) as workers:
        return search_with(workers, problem, Path(folder))


def search_with(workers: Workers, problem: SearchProblem, folder: Path) -> SearchResult:
    """As `run_search`, on workers that are already started; several searches can use them one after
    the other."""
    study, found = Study(problem), []
    with Results(folder, None, COST, ("values",)) as results, _Watch(problem, results) as watch:
        while generation := study.ask():
            left = results.left(generation, again=False)
            watch.know(len(generation) - len(left))
            for record in workers.run(left):
                results.append(record)
                watch.look(record)
            records = [results.records[evaluation.key] for evaluation in generation]
            study.tell(generation, records)
            found += records
            if problem.is_enough(records):
                break
    result = SearchResult(found)
    try:
        write_best(problem, result, folder)
        study.write(folder)
    except UnwritableFile as reason:  # all that they hold is in results.jsonl, and comes back
        print(f"{problem.name}: {reason}; start the search again to write it", file=sys.stderr)
    return result


class _Watch:
    """Progress of a search: rate, time left, least cost; a context."""

    def __init__(self, problem: SearchProblem, results: Results) -> None:
        self._total, self._known, self._run = problem.evaluations, 0, 0
        self._begin, self._line = time.monotonic(), Progress(problem.name)
        costs = [record[COST] for record in results.records.values() if COST in record]
        self._least = min(costs, default=float("inf"))

    def know(self, count: int) -> None:
        """Count evaluations whose results are stored."""
        self._known += count

    def look(self, record: Record) -> None:
        """Count an evaluation that was run, and show the progress."""
        self._run += 1
        self._least = min(self._least, record.get(COST, self._least))
        elapsed, left = time.monotonic() - self._begin, self._total - self._known
        words = pace(self._run, elapsed, left, "evaluations")
        self._line(f"least {self._least:.4g}, {words}", self._known + self._run, self._total)

    def __enter__(self) -> _Watch:
        return self

    def __exit__(self, *_reason: object) -> None:
        self._line.close()


def write_best(problem: SearchProblem, result: SearchResult, folder: Path) -> Path:
    """Write the best evaluation and the least cost up to each one as JSON, in place of an earlier
    file; returns its path.
    """
    content: dict[str, Any] = {
        "format": BEST_FORMAT,
        "name": problem.name,
        "evaluations": len(result.records),
        "failed": result.failed,
        "best": None if result.failed == len(result.records) else result.best,
        "course": result.least_costs(),
    }
    path = folder / BEST
    write_file(path, json.dumps(content, indent=1) + "\n")
    return path
