"""Co-design: every criterion of its run, moulds of random hands, rate, lost processes.

The run is judged as `python -m thesis run co_design` has left it in out/thesis; nothing of it is
run here.
"""

from __future__ import annotations

import json
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from dataclasses import asdict
from itertools import islice
from pathlib import Path
from typing import Any

import numpy as np

from bench.grasps.maps import rows as criteria
from bench.kept import Unfinished
from bench.row import at_least, at_most, stated
from softhand_trials.sweep.run import run_tasks
from thesis import frame
from thesis.__main__ import OUT
from thesis.co_design import hands
from thesis.co_design.arms import BOTH
from thesis.co_design.judged import mould_refusal
from thesis.co_design.plan import LEAST_RATE, NIGHT
from thesis.co_design.trials import DesignTrial, design_of
from thesis.co_design.worlds import trials_of

TAKES = "6 min, on an idle machine"
DESIGNS, TRIALS = 24, 8  # whose rate is measured: as many trials as a second rung has
KILLS = ("test/thesis/co_design/test_kill.py", "test/softhand_trials/sweep/test_cluster.py")
KILLS_LIMIT = 900.0  # [s]


def run(count: int, seed: int) -> list[dict[str, Any]]:
    """Rows of all; `count` hands are cast."""
    return [*_criteria(), *cast(count, seed), *rate(seed), kills()]


def _criteria() -> list[dict[str, Any]]:
    """Those of the night, or that out/thesis has none."""
    try:
        night_results()
    except Unfinished as reason:
        return [at_least(f"co_design: {reason}", 0, "", 1)]
    return criteria("co_design")


def night_results() -> dict[str, Any]:
    """What the night has left in out/thesis; raises Unfinished where that is not there, or another
    plan's.
    """
    path = OUT / "co_design" / frame.RESULT
    if not path.exists():
        raise Unfinished(f"{path} is not there: python -m thesis run co_design")
    results: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))["results"]
    if results["plan"] != json.loads(json.dumps(asdict(NIGHT))):
        raise Unfinished(f"{path} is of another plan: python -m thesis run co_design")
    return results


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
        passed += not any(map(mould_refusal, hands.kinds(values).values()))
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
    yield stated("co-design: trials an hour with one worker", 3600 * len(lines) / one[0], "")
    found = 1800 * len(lines) / two[0]
    yield at_least("co-design: trials a core-hour, two workers", found, "", LEAST_RATE)
    yield at_least("co-design: rate of two workers over one", one[0] / two[0], "", 1.8)
    share = (one[0] - one[1]) / len(lines)
    yield stated("co-design: dispatch of a trial, with the start of one worker", 1e3 * share, "ms")
    busy = one[1] / len(lines) / share
    yield stated("co-design: cores that one dispatcher keeps busy (a model)", busy, "")


def timed(lines: list[DesignTrial], jobs: int) -> tuple[float, float]:
    """Wall time [s] of all, with the start of the workers, and that of the trials themselves."""
    begin = time.perf_counter()
    with tempfile.TemporaryDirectory() as folder:
        records = run_tasks(lines, Path(folder), jobs)
    return time.perf_counter() - begin, sum(record["wall_time"] for record in records)


def kills() -> dict[str, Any]:
    """The tests that kill a worker, a search and a scheduler in its midst."""
    command = [sys.executable, "-m", "pytest", "-q", "-n", "0", *KILLS]
    status = subprocess.run(command, timeout=KILLS_LIMIT).returncode
    name = "co-design: kill -9 of worker, search and scheduler: status of the tests"
    return at_most(name, status, "", 0)
