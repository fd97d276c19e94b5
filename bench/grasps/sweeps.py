"""Sweeps: rate over maps, two workers over one, memory, early end, what a kill costs, Dask.

`python -m bench.grasps.sweeps` prints the table; ten minutes on two idle cores.
"""

from __future__ import annotations

import subprocess
import sys
import time
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import psutil

from bench.__main__ import table
from bench.row import at_least, at_most, stated
from grasp_strategies.sweep import SweepPlan, TrialLine
from grasp_strategies.sweep.cluster import LARGEST_BATCH
from grasp_strategies.sweep.plan import SweptObject, grid
from grasp_strategies.sweep.pool import run_on_processes
from grasp_strategies.sweep.trial_line import Record
from grasp_strategies.trials import TrialSettings
from pneuflex_sim.scene.objects import load_object

STRATEGIES = ("rbo_hand_1_push", "rbo_hand_1_surface")
OBJECTS = ("cylinder", "marker", "tape_dispenser", "tube")
PITCH = 0.02  # [m], of -60 to 60 and -80 to 80 mm
RATED, COMPARED = 80, 400  # trials of the rates, and of early end; spread over the maps
WORKERS = 2000  # of the thesis's cluster
KILLS = ("test_kill.py", "test_cluster.py")
NOTHING = 2000  # batches without work that the dispatch is measured over


def rows(small: bool) -> list[dict[str, Any]]:
    """All figures of sweeps; `small`: of a few trials."""
    lines = map_lines(0.06 if small else PITCH)
    rated = spread(lines, 8 if small else RATED)
    rates, memory = zip(*(rate_and_memory(rated, jobs) for jobs in (1, 2)), strict=True)
    return [
        at_least("trials per core-hour over maps, one worker", rates[0], "", 5000),
        at_least("rate of two workers over that of one", rates[1] / rates[0], "", 1.8),
        at_most("largest memory of a worker", max(memory) / 1e6, "MB", 600),
        *agreement(spread(lines, 16 if small else COMPARED)),
        *kills(),
        *dispatch(lines, 3600 / rates[0], 100 if small else NOTHING),
    ]


def map_lines(pitch: float) -> list[TrialLine]:
    """Trials over maps of both strategies of RBO Hand 1 with 10 segments at 5 ms, early end."""
    cells = grid((-0.06, 0.06, pitch), (-0.08, 0.08, pitch))
    objects = tuple(map(_at_origin, OBJECTS))
    usual = {"model": "rbo_hand_1", "segments": 10, "step": 0.005, "early_end": True}
    plans = [
        SweepPlan(name, TrialSettings(strategy=name, **usual), objects, cells)
        for name in STRATEGIES
    ]
    return [line for plan in plans for line in plan.lines()]


def spread(lines: Sequence[TrialLine], count: int) -> list[TrialLine]:
    """So many of the trials, at even distances."""
    return [lines[k * len(lines) // count] for k in range(min(count, len(lines)))]


def _at_origin(name: str) -> SweptObject:
    """In x > 0, y < 0, and touching both planes."""
    described = load_object(name)
    return SweptObject(name, (described.reach((-1.0, 0.0, 0.0)), -described.reach((0.0, 1.0, 0.0))))


def rate_and_memory(lines: Sequence[TrialLine], jobs: int) -> tuple[float, float]:
    """Trials an hour once every worker has done one, and the largest resident memory [bytes]."""
    times, memory = [], 0.0
    for _ in run_on_processes(lines, jobs):
        times.append(time.perf_counter())
        workers = psutil.Process().children()
        memory = max(memory, *(float(worker.memory_info().rss) for worker in workers))
    counted = times[jobs - 1 :]
    return 3600 * (len(counted) - 1) / (counted[-1] - counted[0]), memory


def agreement(lines: Sequence[TrialLine]) -> list[dict[str, Any]]:
    """Verdicts of trials that end early beside those of whole ones, and the time that is saved."""
    whole = [replace(line, settings=replace(line.settings, early_end=False)) for line in lines]
    short, long = ({r["key"]: r for r in run_on_processes(part, 2)} for part in (lines, whole))
    agree = sum(short[key].get("outcome") == long[key].get("outcome") for key in long)
    return [
        stated("trials ended early and whole", len(lines), ""),
        at_least("verdicts of both that agree", 100 * agree / len(lines), "%", 99.5),
        stated("trials that raised", sum("error" in r for r in long.values()), ""),
        stated("CPU time early over whole", _cpu(short) / _cpu(long), ""),
        stated("mean CPU time of a trial", _cpu(short) / len(lines), "s"),
    ]


def _cpu(records: dict[str, Record]) -> float:
    return sum(record["cpu_time"] for record in records.values())


def kills() -> list[dict[str, Any]]:
    """The tests that kill a worker, a sweep and a scheduler: each line once afterwards."""
    files = [f"test/grasp_strategies/sweep/{name}" for name in KILLS]
    done = subprocess.run([sys.executable, "-m", "pytest", "-q", "-n", "0", *files])
    name = "kill -9 of worker, sweep and scheduler: failed tests of lines lost or twice"
    return [at_most(name, done.returncode, "", 0)]


def no_work(lines: Sequence[TrialLine]) -> list[Record]:
    """A batch that costs its dispatch alone."""
    return [line.describe() for line in lines]


def dispatch(lines: Sequence[TrialLine], trial: float, count: int) -> list[dict[str, Any]]:
    """What Dask costs a batch, and the efficiency that follows for a large cluster.

    A model: one scheduler hands out one batch after the other and does nothing else meanwhile; it
    bounds the batches that are under way. Nothing of it is measured beyond two workers.
    """
    from distributed import Client, LocalCluster, as_completed

    batch = list(lines[:LARGEST_BATCH])
    local = LocalCluster(2, threads_per_worker=1, dashboard_address=None, host="127.0.0.1")
    with local, Client(local) as client:
        client.gather(client.map(no_work, [batch] * 20, pure=False))
        begin = time.perf_counter()
        for future in as_completed(client.map(no_work, [batch] * count, pure=False)):
            future.result()
        cost = (time.perf_counter() - begin) / count
    efficiency = min(1.0, LARGEST_BATCH * trial / (WORKERS * cost))
    return [
        stated(f"Dask: dispatch of a batch of {LARGEST_BATCH}", 1e3 * cost, "ms"),
        stated("Dask: dispatch a trial", 1e3 * cost / LARGEST_BATCH, "ms"),
        stated(f"modelled, not measured: efficiency at {WORKERS} workers", efficiency, ""),
    ]


if __name__ == "__main__":
    print(table(rows("--small" in sys.argv)))
