"""Runs a sweep: what is not done yet, on processes or a cluster, into the folder of its results."""

from __future__ import annotations

import time
from collections.abc import Iterator, Sequence
from pathlib import Path

from grasp_strategies.sweep.cluster import run_on_cluster
from grasp_strategies.sweep.plan import SweepPlan
from grasp_strategies.sweep.pool import run_on_processes
from grasp_strategies.sweep.results import Results, read_results
from grasp_strategies.sweep.trial_line import Record, TrialLine
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
    lines: Sequence[TrialLine],
    folder: str | Path,
    jobs: int = 2,
    scheduler: str | None = None,
    name: str = "sweep",
) -> list[Record]:
    """The same for a list of trials."""
    if len({line.key for line in lines}) < len(lines):
        raise ValueError("trials: expected keys that differ, got some twice")
    with Results(Path(folder), lines) as results, Progress(name) as progress:
        left = [line for line in lines if line.key not in results.done]
        begin, before = time.monotonic(), len(results.done)
        for record in _records(left, jobs, scheduler):
            results.append(record)
            done = len(results.done)
            progress(_pace(done - before, time.monotonic() - begin, len(left)), done, len(lines))
    found = {record["key"]: record for record in read_results(results.path)}
    return [found[line.key] for line in lines]


def _records(left: Sequence[TrialLine], jobs: int, scheduler: str | None) -> Iterator[Record]:
    if not left:
        return iter(())
    return run_on_processes(left, jobs) if scheduler is None else run_on_cluster(left, scheduler)


def _pace(count: int, elapsed: float, left: int) -> str:
    """Rate and time left, in words."""
    rate = count / elapsed
    minutes, seconds = divmod(round((left - count) / rate), 60)
    return f"{3600 * rate:,.0f} trials an hour, {minutes}:{seconds:02d} left"
