"""Whether trials that end once their verdict is certain have the verdict of the full trial."""

from __future__ import annotations

import time
from dataclasses import replace
from typing import Any

from bench.grasps.steps import scattered
from bench.grasps.verdicts import gripped
from bench.row import at_least

TAKES = "half an hour"
COUNT = 400


def run(seed: int, jobs: int, minutes: float = 120.0, count: int = COUNT) -> list[dict[str, Any]]:
    """Share of scattered trials of the maps with the same verdict, short and full."""
    short, end = scattered(seed + 1, count), time.monotonic() + 60 * minutes
    long = [replace(line, settings=replace(line.settings, early_end=False)) for line in short]
    ended = gripped("early_end-short", short, jobs, end)
    run_out = gripped("early_end-long", long, jobs, end)
    same = sum(ended[key] == run_out[key] for key in ended)
    what = f"verdict of the short way, {count} trials, {sum(run_out.values())} of them gripped"
    return [at_least(what, 100 * same / count, "%", 99.5)]
