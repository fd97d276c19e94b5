"""Whether a trial that ends as soon as its verdict is sure has the verdict of the long way."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from bench.grasps.steps import gripped, scattered
from bench.row import at_least

COUNT = 400


def run(seed: int, jobs: int, count: int = COUNT) -> list[dict[str, Any]]:
    """Share of scattered trials of the maps with the same verdict on both ways."""
    short = scattered(seed + 1, count)
    long = [replace(line, settings=replace(line.settings, early_end=False)) for line in short]
    ended, run_out = gripped(short, jobs), gripped(long, jobs)
    same = sum(ended[key] == run_out[key] for key in ended)
    return [at_least(f"verdict of the short way, {count} trials", 100 * same / count, "%", 99.5)]
