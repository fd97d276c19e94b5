"""Runs the trials of a sweep that have no result yet, on processes or a cluster."""

from __future__ import annotations

import time
from collections.abc import Sequence
from pathlib import Path

from softhand_common.progress import Progress
from softhand_trials.sweep.cluster import Cluster
from softhand_trials.sweep.plan import SweepPlan
from softhand_trials.sweep.pool import Processes
from softhand_trials.sweep.results import Results
from softhand_trials.sweep.task import Record, Task

Workers = Processes | Cluster


def run_sweep(
    plan: SweepPlan, folder: str | Path, jobs: int = 2, scheduler: str | None = None
) -> list[Record]:
    """Run the trials of a plan that have no result yet; return the records of all its trials, in
    the order of the plan.

    Args:
        plan: what to run.
        folder: folder of `results.jsonl`, which is made if missing.
        jobs: number of processes; 0: run in this process.
        scheduler: address of a Dask scheduler, such as `tls://node:8786`, instead of processes.

    Raises:
        ValueError: the folder holds results of another plan, or of a sweep that still runs; or a
            result cannot be written.
        ConnectionError: the scheduler or its workers are not there, or got lost.
    """
    return run_tasks(plan.tasks(), folder, jobs, scheduler, plan.name)


def run_tasks(
    tasks: Sequence[Task],
    folder: str | Path,
    jobs: int = 2,
    scheduler: str | None = None,
    name: str = "sweep",
) -> list[Record]:
    """As `run_sweep`, for a list of tasks; `name` stands in the lines of progress."""
    if len({task.key for task in tasks}) < len(tasks):
        raise ValueError("trials: expected each key once, got some twice")
    with (
        Results(Path(folder), tasks) as results,
        start_workers(jobs, scheduler) as workers,
        Progress(name) as progress,
    ):
        left = results.left(tasks)
        begin, before = time.monotonic(), len(tasks) - len(left)
        for count, record in enumerate(workers.run(left), 1):
            results.append(record)
            words = pace(count, time.monotonic() - begin, len(left))
            progress(words, before + count, len(tasks))
        return [results.records[task.key] for task in tasks]


def finish(
    workers: Workers, tasks: Sequence[Task], results: Results, again: bool = True
) -> list[Record]:
    """Run the tasks that have no result yet; return the records of all. With `again`, tasks that
    ended in an error are run again; do not use it where later tasks were chosen by that error.
    """
    for record in workers.run(results.left(tasks, again)):
        results.append(record)
    return [results.records[task.key] for task in tasks]


def start_workers(jobs: int, scheduler: str | None = None) -> Workers:
    """Workers as a context manager: `jobs` processes (0: this process), or those of a Dask
    scheduler.
    """
    return Processes(jobs) if scheduler is None else Cluster(scheduler)


def pace(count: int, elapsed: float, left: int, what: str = "trials") -> str:
    """Rate, and time left as minutes:seconds, in words.

    Args:
        count: number of tasks done so far.
        elapsed: time that these took [s].
        left: number of tasks in all, including those of `count`.
        what: word for the tasks.

    >>> pace(10, 20.0, 40)  # 30 are left, at 2 s each
    '1,800 trials an hour, 1:00 left'
    """
    rate = count / elapsed
    minutes, seconds = divmod(round((left - count) / rate), 60)
    return f"{3600 * rate:,.0f} {what} an hour, {minutes}:{seconds:02d} left"
