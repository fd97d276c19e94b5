"""Co-design: every criterion of its run, moulds of random hands, rate, lost processes.

The run is judged as `python -m thesis run co_design` has left it in out/thesis; nothing of it is
run here.
"""

from __future__ import annotations

import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from itertools import islice
from pathlib import Path
from typing import Any

import numpy as np

from bench.grasps.maps import rows as criteria
from bench.row import at_least, at_most, stated
from grasp_strategies.sweep.run import run_lines
from pneuflex_sim.mould.report import make_mould
from thesis.co_design import hands
from thesis.co_design.arms import BOTH
from thesis.co_design.plan import LEAST_RATE, NIGHT
from thesis.co_design.trials import DesignTrial, design_of
from thesis.co_design.worlds import trials_of

TAKES = "6 min, on an idle machine"
DESIGNS, TRIALS = 24, 8  # whose rate is measured: as many trials as a second rung has
KILLS = ("test/thesis/co_design/test_kill.py", "test/grasp_strategies/sweep/test_cluster.py")
KILLS_LIMIT = 900.0  # [s]


def run(count: int, seed: int) -> list[dict[str, Any]]:
    """Rows of all; `count` hands are cast."""
    return [*criteria("co_design"), *cast(count, seed), *rate(seed), kills()]


def drawn(variables: Any, seed: int) -> Iterator[dict[str, float]]:
    """Random designs without end that can be built, and by the cheap check be cast."""
    random = np.random.default_rng(seed)
    while True:
        values = {v.name: float(random.uniform(v.low, v.high)) for v in variables}
        if not hands.broken(hands.SHIPPED | values):
            yield values


def cast(count: int, seed: int) -> Iterator[dict[str, Any]]:
    """Whether moulds of random hands that were not refused pass every check."""
    passed = 0
    for values in islice(drawn(hands.VARIABLES, seed), count):
        passed += not any(make_mould(part).failed for part in hands.kinds(values).values())
    yield at_least(f"co-design: hands whose moulds pass, of {count} drawn", passed, "", count)


def rate(seed: int) -> Iterator[dict[str, Any]]:
    """Trials a core-hour of random designs, and what a second worker brings."""
    designs = [
        design_of(values) for _, values in zip(range(DESIGNS), drawn(BOTH, seed), strict=False)
    ]
    lines = [
        line
        for number, design in enumerate(designs)
        for line in trials_of(str(number), design, NIGHT.training, seed, range(TRIALS))
    ]
    timed(lines[:4], 2)  # compiles
    one, two = timed(lines, 1), timed(lines, 2)
    yield stated("co-design: trials an hour with one worker", 3600 * len(lines) / one, "")
    found = 1800 * len(lines) / two
    yield at_least("co-design: trials a core-hour, two workers", found, "", LEAST_RATE)
    yield at_least("co-design: rate of two workers over one", one / two, "", 1.8)


def timed(lines: list[DesignTrial], jobs: int) -> float:
    """Wall time [s] of trials."""
    begin = time.perf_counter()
    with tempfile.TemporaryDirectory() as folder:
        run_lines(lines, Path(folder), jobs)
    return time.perf_counter() - begin


def kills() -> dict[str, Any]:
    """The tests that kill a worker, a search and a scheduler in its midst."""
    command = [sys.executable, "-m", "pytest", "-q", "-n", "0", *KILLS]
    status = subprocess.run(command, timeout=KILLS_LIMIT).returncode
    name = "co-design: kill -9 of worker, search and scheduler: status of the tests"
    return at_most(name, status, "", 0)
