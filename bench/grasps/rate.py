"""How fast a map is made: trials a core-hour, two workers over one, memory of a worker."""

from __future__ import annotations

import tempfile
import threading
import time
from pathlib import Path
from typing import Any

import psutil

from bench.grasps.steps import OF_OBJECTS, scattered
from bench.row import at_least, at_most, stated
from softhand_trials.sweep import TrialTask, run_tasks

TAKES = "8 min, on an idle machine"
COUNT = 360  # trials of either run: a map has thousands, over which its start counts little
LOOK = 0.5  # [s] between two looks at the workers' memory


def run(seed: int, count: int = COUNT) -> list[dict[str, Any]]:
    """The same trials with one worker and with two, each after a run that compiles."""
    lines = scattered(seed + 2, count, OF_OBJECTS)
    timed(lines[:4], 2)
    one, _ = timed(lines, 1)
    two, memory = timed(lines, 2)
    return [
        stated("trials an hour with one worker", 3600 * count / one, ""),
        at_least("trials a core-hour over the maps, two workers", 1800 * count / two, "", 5000),
        at_most("a map of 8 objects, 89 cells, 3 replicates", _minutes(8, two / count), "min", 30),
        at_most("the 14 maps of section 8.1.2 so", _minutes(14, two / count), "min", 60),
        at_least("rate of two workers over one", one / two, "", 1.8),
        at_most("memory of a worker", memory, "MB", 600),
    ]


def _minutes(objects: int, time: float) -> float:
    """Time of maps [min] with 89 cells an object, three times each, from that of a trial [s]."""
    return objects * 89 * 3 * time / 60


def timed(lines: list[TrialTask], jobs: int) -> tuple[float, float]:
    """Wall time of a sweep [s] and the greatest memory of a worker [MB]."""
    over, most = threading.Event(), [0.0]

    def look() -> None:
        while not over.wait(LOOK):
            for worker in psutil.Process().children(recursive=True):
                try:
                    most[0] = max(most[0], worker.memory_info().rss / 1e6)
                except psutil.NoSuchProcess:
                    continue

    watcher = threading.Thread(target=look)
    watcher.start()
    begin = time.perf_counter()
    with tempfile.TemporaryDirectory() as folder:
        run_tasks(lines, Path(folder), jobs)
    spent = time.perf_counter() - begin
    over.set()
    watcher.join()
    return spent, most[0]
