"""How long the lab takes: on usual sets until its first look and in all, and on large sets.

`python -m bench.lab.speed [--large]`: processor seconds of `diagnose` by the command line, loading
included, medians over the sets of NAMED_SETS and REFUSED_SETS, each with its target.
"""

from __future__ import annotations

import argparse
import os
import statistics
import subprocess
import sys
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
from model_lab.report.first_look_text import FIRST_LOOK as FIRST_LOOK_LINE

Seconds = tuple[float, float]
"""By the clock, and of processors."""

LARGE = {"tube_lag": 15.0, "hysteresis": 30.0}  # hidden effect of 36 runs x 800 samples: target [s]
HELD = 15.0  # [s]: median of diagnoses of a held actuator
# targets [s of processors] of usual bending sets, by the command line, loading included: medians
FIRST_LOOK, WHOLE, REFUSAL = 3.0, 10.0, 30.0
NAMED_SETS = (
    "free_bending/gent_stiffening/medium",
    "free_bending/tube_lag/medium",
    "free_bending/hysteresis/medium",
    "free_bending/pressure_offset/medium",
    "free_bending/creep/medium",
    "pair/free_bending/hysteresis+tube_lag",
    "nothing/free_bending/tapered",
)
REFUSED_SETS = (
    "outside/free_bending/ringing/3",
    "outside/free_bending/gain_step/10",
    "outside/free_bending/stuck_encoder/5",
)
SEED, NOISE = 1, 0.006
JUDGED = {"processor_seconds": "s of processors", "seconds": "s by the clock"}


def measure_speed(large: bool = True) -> list[dict[str, Any]]:
    """Seconds, and those of processors, of `diagnose` on usual sets.

    large: also on 36 runs of 800 samples and on held actuators, and of `compare` on a million
    samples.
    """
    with tempfile.TemporaryDirectory(prefix="bench-lab-") as folder:
        found = _usual(Path(folder))
        if not large:
            return found
        found += [_diagnosed(Path(folder) / law, law, target) for law, target in LARGE.items()]
        found.append(_held(Path(folder)))
        huge = Path(folder) / "huge"
        make_set(huge, "free_bending", [], seed=SEED, samples=83334)
        found.append(_timed("compare, 1,000,008 samples", 10.0, [partial(comparison_of, huge)]))
    return found


def text_of(row: dict[str, Any]) -> str:
    """A row in a line, with its target as met or missed."""
    word = "met" if row[row["judged"]] <= row["target"] else "MISSED"
    spent = f"{row['processor_seconds']:.1f} s of processors, {row['seconds']:.1f} s by the clock"
    target = f"target {row['target']:g} {JUDGED[row['judged']]}: {word}"
    return f"{row['name']}: {spent}, median of {row['sets']} ({target})"


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
    return _timed("diagnose, base_torque", HELD, calls)


def _usual(folder: Path) -> list[dict[str, Any]]:
    """Usual bending sets by the command line: first look and whole, and whole of refusals."""
    cases = {case.name: case for case in all_cases()}
    named, refused = (
        [_streamed(cases[name].make, folder / name) for name in names]
        for names in (NAMED_SETS, REFUSED_SETS)
    )
    parts = [
        ("diagnose, bending: first answer", FIRST_LOOK, [first for first, _ in named]),
        ("diagnose, bending: whole", WHOLE, [whole for _, whole in named]),
        ("diagnose, bending: refusal", REFUSAL, [whole for _, whole in refused]),
    ]
    return [row_of(name, target, seconds, "processor_seconds") for name, target, seconds in parts]


def _streamed(make: Callable[[Path, int, float], Any], folder: Path) -> tuple[Seconds, Seconds]:
    """Seconds of a diagnosis by the command line: until its first look, and in all."""
    make(folder, SEED, NOISE)
    started, used = time.perf_counter(), _used()
    command = [sys.executable, "-m", "model_lab", "diagnose", str(folder), "--jobs", "1"]
    with subprocess.Popen(
        command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True
    ) as process:
        for line in process.stderr or ():
            if line.startswith(FIRST_LOOK_LINE):
                first = time.perf_counter() - started, _used_by(process.pid)
        if process.wait():
            raise RuntimeError(f"{folder}: the diagnosis failed")
    return first, (time.perf_counter() - started, _used() - used)


def _used_by(process: int) -> float:
    """Processor time [s] of a process that runs."""
    fields = Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def _timed(name: str, target: float, calls: list[Callable[[], Any]]) -> dict[str, Any]:
    """Median over the calls."""
    return row_of(name, target, list(map(_seconds, calls)), "seconds")


def row_of(name: str, target: float, seconds: list[Seconds], judged: str) -> dict[str, Any]:
    """Medians, and which of them the target [s] holds for (a key of JUDGED)."""
    wall, processors = zip(*seconds, strict=True)
    return {
        "name": name,
        "seconds": statistics.median(wall),
        "processor_seconds": statistics.median(processors),
        "sets": len(seconds),
        "target": target,
        "judged": judged,
    }


def _seconds(call: Callable[[], Any]) -> Seconds:
    started, used = time.perf_counter(), _used()
    call()
    return time.perf_counter() - started, _used() - used


def _used() -> float:
    usages = getrusage(RUSAGE_SELF), getrusage(RUSAGE_CHILDREN)
    return sum(usage.ru_utime + usage.ru_stime for usage in usages)


def main(arguments: list[str] | None = None) -> int:
    """Measure and print."""
    parser = argparse.ArgumentParser(prog="bench.lab.speed", description=__doc__.splitlines()[0])
    parser.add_argument("--large", action="store_true", help="large sets and held actuators, too")
    print(*map(text_of, measure_speed(parser.parse_args(arguments).large)), sep="\n")
    return 0


if __name__ == "__main__":
    sys.exit(main())
