"""Successive halving (Jamieson and Talwalkar, AISTATS 2016): each round has the candidates
that were best in the rounds before it.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from softhand_trials.sweep.results import Results
from softhand_trials.sweep.run import Workers, finish
from softhand_trials.sweep.task import Record, Task


def successive_halving(
    workers: Workers,
    results: Results,
    candidates: Sequence[int],
    tasks: Callable[[int, int], Sequence[Task]],
    rank: Callable[[int, Sequence[Record]], Any],
    again: bool = True,
) -> tuple[list[int], list[list[Record]]]:
    """Run rounds of trials, each with the candidates that rank first so far.

    Args:
        workers: workers that run the trials.
        results: results of the trials, from which an interrupted run continues.
        candidates: number of candidates in each round; the first has all of them.
        tasks: returns the trials of a candidate in a round, given the numbers of both, counted from
            0.
        rank: returns what candidates are sorted by, given a candidate's number and all its records;
            the least comes first.
        again: whether trials that ended in an error are tried again when the run is started again.

    Returns:
        Numbers of all candidates, those that came furthest first and among these the best first;
        and the records of each candidate by its number.
    """
    order = list(range(candidates[0]))
    records: list[list[Record]] = [[] for _ in order]
    for number, count in enumerate(candidates):
        tried = {k: tasks(k, number) for k in order[:count]}
        finish(workers, [task for some in tried.values() for task in some], results, again)
        for k, some in tried.items():
            records[k] += [results.records[task.key] for task in some]
        order = sorted(tried, key=lambda k: rank(k, records[k])) + order[count:]
    return order, records
