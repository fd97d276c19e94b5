"""Cost of lost processes in a sweep, and overhead of Dask per trial."""

from __future__ import annotations

import subprocess
import sys
import time
from collections.abc import Sequence
from typing import Any

from bench.grasps.steps import OF_OBJECTS, scattered
from bench.row import at_most, stated
from softhand_trials.sweep import TrialTask, run_task
from softhand_trials.sweep.cluster import LARGEST_BATCH
from softhand_trials.sweep.task import Record

TAKES = "5 min"
KILLS = ("test_kill.py", "test_cluster.py")
KILLS_LIMIT = 900.0  # [s]
WORKERS = 2000  # of the thesis's cluster
COUNT = 2000  # batches without work that the dispatch is measured over
TRIALS = 20  # that tell how long one takes


def run(seed: int, count: int = COUNT) -> list[dict[str, Any]]:
    """Rows of both."""
    return [*kills(), *dispatch(scattered(seed, TRIALS, OF_OBJECTS), count)]


def kills() -> list[dict[str, Any]]:
    """The tests that kill a worker, a sweep and a scheduler in its midst: each line once after."""
    files = [f"test/softhand_trials/sweep/{name}" for name in KILLS]
    done = subprocess.run(
        [sys.executable, "-m", "pytest", "-q", "-n", "0", *files], timeout=KILLS_LIMIT
    )
    name = "kill -9 of worker, sweep and scheduler: status of the tests of lines lost or twice"
    return [at_most(name, done.returncode, "", 0)]


def no_work(lines: Sequence[TrialTask]) -> list[Record]:
    """A batch that costs its dispatch alone."""
    return [line.describe() for line in lines]


def dispatch(lines: Sequence[TrialTask], count: int) -> list[dict[str, Any]]:
    """What Dask costs a batch, and the efficiency that follows for a large cluster.

    This is a model: one scheduler hands out one batch after the other, and that alone limits how
    many workers are busy. It was not measured with more than two workers.
    """
    trial = sum(run_task(line)["cpu_time"] for line in lines) / len(lines)
    batch = (list(lines) * LARGEST_BATCH)[:LARGEST_BATCH]
    cost = dispatch_time(batch, count)
    busy = min(1.0, LARGEST_BATCH * trial / cost / WORKERS)
    return [
        stated(f"Dask: dispatch of a batch of {LARGEST_BATCH} trials", 1e3 * cost, "ms"),
        stated("Dask: dispatch a trial", 1e3 * cost / LARGEST_BATCH, "ms"),
        stated("modelled, not measured: workers that a scheduler keeps busy", busy * WORKERS, ""),
        stated(f"modelled, not measured: efficiency at {WORKERS} workers", busy, ""),
    ]


def dispatch_time(batch: Sequence[TrialTask], count: int) -> float:
    """Time a batch without work [s], of a scheduler with two workers on this machine."""
    from distributed import Client, LocalCluster, as_completed

    local = LocalCluster(2, threads_per_worker=1, dashboard_address=None, host="127.0.0.1")
    with local, Client(local) as client:
        client.gather(client.map(no_work, [batch] * 20, pure=False))
        begin = time.perf_counter()
        for future in as_completed(client.map(no_work, [batch] * count, pure=False)):
            future.result()
        return (time.perf_counter() - begin) / count
