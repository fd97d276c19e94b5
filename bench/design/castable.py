"""Moulds of the shipped actuators and of random designs by two numbers, and by profiles."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from bench.design.requests import feasible
from bench.moulds import rows
from bench.row import at_least
from softhand_design.mould.report import make_mould, refusal

TAKES = "some minutes"


def run(count: int = 20, seed: int = 0) -> list[dict[str, Any]]:
    """Rows of the group."""
    return [*rows(count), *_of_profiles(count, seed)]


def _of_profiles(count: int, seed: int) -> Iterator[dict[str, Any]]:
    passed = 0
    for design in feasible(count, seed):
        try:
            made = make_mould(design.actuator)
        except ValueError as reason:
            print(f"{design.actuator.name}: {reason}", flush=True)
            continue
        passed += not made.failed
        print(refusal(made) if made.failed else f"{made.actuator.name}: passed", flush=True)
    yield at_least(f"moulds of {count} designs by profiles that pass", passed, "", count)
