"""Do both engines come to the same verdict? Shipped strategies with each object at its place; and
where they differ, at a fine step, and with the object moved by a little.

Trials that are finished are kept in out/bench/sim-verdicts.jsonl, so that a stopped run goes on.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

from bench import kept
from bench.row import at_least, stated
from grasp_strategies.strategy import load_strategy, strategy_names
from pneuflex_sim.engines import ENGINES
from pneuflex_sim.scene.objects import load_object, load_objects
from softhand_trials.trials import Placement, StartedScene, TrialSettings

KEPT = Path("out/bench/sim-verdicts.jsonl")
SOURCES = (
    "src/grasp_strategies",
    "src/pneuflex_sim",
    "src/softhand_model",
    "src/softhand_trials",
)
TARGET = 0.9  # share of strategies and objects with the same verdict
FINE = 0.0005  # [s] step
NEAR = 0.005  # [m] by which the object is moved in four directions
MOVES = ((NEAR, 0.0), (-NEAR, 0.0), (0.0, NEAR), (0.0, -NEAR))


def nominal_trials(small: bool) -> Iterator[tuple[str, str, TrialSettings, Placement]]:
    """Shipped strategies with their hand, each with the objects that both engines can simulate (or,
    when it is small, those that it is known to lift), where the strategy has them.
    """
    rigid = [name for name, thing in load_objects().items() if not thing.compliance]
    for name in strategy_names():
        strategy = load_strategy(name)
        tried = strategy.tried_with
        for thing in strategy.objects if small else rigid:
            upright = (0.0, 0.0, 0.0) if thing in tried.upright else None
            described = load_object(thing)
            described = described if upright is None else replace(described, rpy=upright)
            settings = TrialSettings(
                name,
                thing,
                tried.scene,
                tried.model or None,
                tried.step,
                tried.segments,
                wall_inclination=tried.wall_inclination,
                object_rpy=upright,
                early_end=True,
            )
            place = described.corner_place if tried.place is None else tried.place
            yield name, thing, settings, Placement(place)


def both(settings: TrialSettings, placement: Placement) -> dict[str, tuple[bool, str]]:
    """Whether the object is gripped, and the reason, by engine."""
    found = {}
    for name in ENGINES:
        result = StartedScene(replace(settings, engine=name)).run(placement)
        found[name] = (result.gripped, result.reason)
    return found


def nearby(settings: TrialSettings, placement: Placement) -> dict[str, int]:
    """At how many of four places around its own an object is gripped, by engine."""
    x, y = placement.offset
    places = [replace(placement, offset=(x + dx, y + dy)) for dx, dy in MOVES]
    counts = {}
    for name in ENGINES:
        started = StartedScene(replace(settings, engine=name))
        counts[name] = sum(started.run(place).gripped for place in places)
    return counts


def rows(small: bool) -> list[dict[str, Any]]:
    """Share of pairs of strategy and object that end alike in both engines, and what the others
    are; each is printed.
    """
    once = kept.Once(KEPT, SOURCES)
    same, count, tried_same, tried = 0, 0, 0, 0
    at_fine, changing, apart = 0, 0, 0
    for strategy, thing, settings, placement in nominal_trials(small):
        key = f"{strategy}, {thing}"
        found = once(key, lambda s=settings, p=placement: both(s, p))
        agree = len({held for held, _ in found.values()}) == 1
        same, count = same + agree, count + 1
        if thing in load_strategy(strategy).objects:
            tried_same, tried = tried_same + agree, tried + 1
        told = "; ".join(f"{name}: {reason}" for name, (_, reason) in found.items())
        print(f"{'same' if agree else 'differs'}: {key}: {told}", flush=True)
        if agree:
            continue
        fine = once(f"{key}, fine", lambda s=settings, p=placement: both(replace(s, step=FINE), p))
        at_fine += len({held for held, _ in fine.values()}) == 1
        words = {name: reason for name, (_, reason) in fine.items()}
        print(f"    at {1e3 * FINE:g} ms: {words}", flush=True)
        counts = once(f"{key}, nearby", lambda s=settings, p=placement: nearby(s, p))
        totals = {name: counts[name] + found[name][0] for name in ENGINES}
        print(f"    of five places gripped: {totals}", flush=True)
        if all(total in (0, len(MOVES) + 1) for total in totals.values()):
            apart += 1
        else:
            changing += 1
    what = "strategies x objects: same verdict in both engines"
    return [
        at_least(f"{what}, {count} pairs", same / count, "", TARGET),
        stated(f"{what}, {tried} that are known to succeed", tried_same / tried, ""),
        stated(
            f"differing pairs: same verdict at steps of {1e3 * FINE:g} ms",
            at_fine,
            f"of {count - same}",
        ),
        stated(
            "differing pairs: an engine's own verdict changes within 5 mm",
            changing,
            f"of {count - same}",
        ),
        stated(
            "differing pairs: one engine grips at all five places, the other at none",
            apart,
            f"of {count - same}",
        ),
    ]
