"""Verdicts of many trials, kept by the state of the code: stopped, a row goes on where it was."""

from __future__ import annotations

import time
from collections.abc import Sequence
from pathlib import Path

from bench.kept import Unfinished
from grasp_strategies.judging.judge import GRIPPED
from grasp_strategies.sweep import TrialLine, run_lines
from grasp_strategies.sweep.line import versions
from grasp_strategies.sweep.success_map import finished

OUT = Path("out/bench/sweeps")
PART = 200  # trials between two looks at the time


def gripped(name: str, lines: Sequence[TrialLine], jobs: int, end: float) -> dict[str, bool]:
    """Verdicts by key.

    Args:
        name: of the folder in which they are kept.
        lines: the trials.
        jobs: processes.
        end: when no further trials are begun [s, monotonic].

    Raises:
        Unfinished: the time is over.
        RuntimeError: a trial has no verdict.
    """
    folder = OUT / f"{name}-{versions()['code']}"
    verdicts: dict[str, bool] = {}
    for done in range(0, len(lines), PART):
        if time.monotonic() > end:
            raise Unfinished(f"{name}: {len(lines) - done} of {len(lines)} trials are left")
        # those before are in the folder
        records = finished(run_lines(lines[: done + PART], folder, jobs))
        verdicts = {record["key"]: record["outcome"] == GRIPPED for record in records}
    return verdicts
