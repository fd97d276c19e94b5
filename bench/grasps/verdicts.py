"""Verdicts of many trials, stored by the state of the code: an interrupted bench goes on where it
was.
"""

from __future__ import annotations

import time
import zlib
from collections.abc import Sequence
from pathlib import Path

from bench.kept import Unfinished
from grasp_strategies.judging.judge import OUTCOME_GRIPPED
from softhand_trials.sweep import TrialTask, run_tasks
from softhand_trials.sweep.results import read_results
from softhand_trials.sweep.success_map import finished
from softhand_trials.sweep.task import versions

OUT = Path("out/bench/sweeps")
PART = 200  # trials between two looks at the time


def gripped(name: str, lines: Sequence[TrialTask], jobs: int, end: float) -> dict[str, bool]:
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
    drawn = zlib.crc32("\n".join(line.digest for line in lines).encode())
    folder = OUT / f"{name}-{versions()['code']}-{drawn:08x}"
    verdicts: dict[str, bool] = {}
    kept = len({record["key"] for record in read_results(folder)})
    # what is kept is of the first parts
    for part in range(max(kept - 1, 0) // PART * PART, len(lines), PART):
        if time.monotonic() > end and kept < len(lines):
            raise Unfinished(f"{name}: {len(lines) - kept} of {len(lines)} trials are left")
        records = finished(run_tasks(lines[: part + PART], folder, jobs))
        kept = len(records)
        verdicts = {record["key"]: record["outcome"] == OUTCOME_GRIPPED for record in records}
    return verdicts
