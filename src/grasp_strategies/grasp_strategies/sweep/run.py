"""Runs a sweep: what is not done yet, on processes or a cluster, into the folder of its results."""

from __future__ import annotations

import time
from collections.abc import Sequence
from pathlib import Path

from grasp_strategies.sweep.cluster import Cluster
from grasp_strategies.sweep.line import Line, Record
from grasp_strategies.sweep.plan import SweepPlan
from grasp_strategies.sweep.pool import Processes
from grasp_strategies.sweep.results import Results
from softhand_model.progress import Progress


def run_sweep(
    plan: SweepPlan, folder: str | Path, jobs: int = 2, scheduler: str | None = None
) -> list[Record]:
    """Run what is left of a plan; the records of all its trials, in the plan's order.

    Args:
        plan: what to run.
        folder: where `results.jsonl` is, or comes to be.
        jobs: processes at a time; 0: in this one.
        scheduler: address of a Dask scheduler, such as `tcp://node:8786`, instead of processes.

    Raises:
        ValueError: the folder holds results of another plan, or of a sweep that still runs.
        ConnectionError: the scheduler or its workers are not there, or got lost.
    """
    return run_lines(plan.lines(), folder, jobs, scheduler, plan.name)


def run_lines(
    lines: Sequence[Line],
    folder: str | Path,
    jobs: int = 2,
    scheduler: str | None = None,
    name: str = "sweep",
) -> list[Record]:
    """The same for a list of lines."""
    if len({line.key for line in lines}) < len(lines):
        raise ValueError("trials: expected keys that differ, got some twice")
    with (
        Results(Path(folder), lines) as results,
        workers(jobs, scheduler) as crew,
        Progress(name) as progress,
    ):
        left = results.left(lines)
        begin, before = time.monotonic(), len(lines) - len(left)
        for count, record in enumerate(crew.run(left), 1):
            results.append(record)
            words = pace(count, time.monotonic() - begin, len(left))
            progress(words, before + count, len(lines))
        return [results.records[line.key] for line in lines]


def workers(jobs: int, scheduler: str | None = None) -> Processes | Cluster:
    """Who runs lines: `jobs` processes (0: this one), or the workers of a Dask scheduler."""
    return Processes(jobs) if scheduler is None else Cluster(scheduler)


def pace(count: int, elapsed: float, left: int, what: str = "trials") -> str:
    """Rate and time left, in words.

    >>> pace(10, 20.0, 40)
    '1,800 trials an hour, 1:00 left'
    """
    rate = count / elapsed
    minutes, seconds = divmod(round((left - count) / rate), 60)
    return f"{3600 * rate:,.0f} {what} an hour, {minutes}:{seconds:02d} left"
