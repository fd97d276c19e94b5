"""How long the lab takes on large sets."""

from __future__ import annotations

import statistics
import tempfile
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path
from resource import RUSAGE_CHILDREN, RUSAGE_SELF, getrusage
from typing import Any

from bench.hidden import make_set
from bench.hidden.cases import all_cases
from bench.lab.adapter import comparison_of, diagnosis_of

LARGE = {"tube_lag": 15.0, "hysteresis": 30.0}  # hidden effect of 36 runs x 800 samples: target [s]
HELD = 15.0  # [s]: median of diagnoses of a held actuator
SEED, NOISE = 1, 0.006


def measure_speed() -> list[dict[str, Any]]:
    """Seconds, and those of processors, of `diagnose` on 36 runs of 800 samples and on held
    actuators, and of `compare` on a million samples.
    """
    with tempfile.TemporaryDirectory(prefix="bench-lab-") as folder:
        found = [_diagnosed(Path(folder) / law, law, target) for law, target in LARGE.items()]
        found.append(_held(Path(folder)))
        huge = Path(folder) / "huge"
        make_set(huge, "free_bending", [], seed=SEED, samples=83334)
        found.append(_timed("compare, 1,000,008 samples", 10.0, [partial(comparison_of, huge)]))
    return found


def _diagnosed(folder: Path, law: str, target: float) -> dict[str, Any]:
    hidden, size = [(law, {})], {"runs": 36, "repeats": 6, "samples": 800}
    make_set(folder, "free_bending", hidden, seed=SEED, ratio=4.0, **size)
    name = f"diagnose, 36 runs x 800 samples, {law}"
    return _timed(name, target, [partial(diagnosis_of, folder, 0, jobs=2)])


def _held(folder: Path) -> dict[str, Any]:
    cases = [c for c in all_cases() if c.experiment == "base_torque" and c.row == "catalogue"]
    for number, case in enumerate(cases):
        case.make(folder / f"held{number}", SEED, NOISE)
    calls = [partial(diagnosis_of, folder / f"held{n}", 0, jobs=2) for n in range(len(cases))]
    return _timed("diagnose, base_torque, median", HELD, calls)


def _timed(name: str, target: float, calls: list[Callable[[], Any]]) -> dict[str, Any]:
    """Median over the calls."""
    wall, processors = zip(*map(_seconds, calls), strict=True)
    return {
        "name": name,
        "seconds": statistics.median(wall),
        "processor_seconds": statistics.median(processors),
        "target": target,
    }


def _seconds(call: Callable[[], Any]) -> tuple[float, float]:
    started, used = time.perf_counter(), _used()
    call()
    return time.perf_counter() - started, _used() - used


def _used() -> float:
    usages = getrusage(RUSAGE_SELF), getrusage(RUSAGE_CHILDREN)
    return sum(usage.ru_utime + usage.ru_stime for usage in usages)
