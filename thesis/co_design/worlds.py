"""The trials of a design (objects and their placement), and the score of their results.

They follow from the seed alone, so that all designs of all arms at a seed have the same trials.
"""

from __future__ import annotations

import zlib
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np

from grasp_strategies.judging.judge import OUTCOME_GRIPPED, OUTCOME_LOST
from softhand_trials.trials import Placement
from thesis.co_design.plan import World
from thesis.co_design.trials import Design, DesignTrial, Physics, Shared

USUAL = Physics()
WORST, WEIGHT = 0.25, 0.25  # share of the objects, and weight of their mean
HIGHEST = 1.0 + WEIGHT  # of scores
LOST_COUNTS = 0.01  # of a trial that took the object off the ground: it breaks ties


def trials_of(
    name: str,
    design: Design,
    world: World,
    seed: int,
    numbers: Sequence[int] | None = None,
    physics: Physics = USUAL,
) -> list[DesignTrial]:
    """Trials of a design; those of one scene follow each other.

    Args:
        name: first part of their keys.
        design: hand and motion.
        world: objects and how they are placed.
        seed: of the draws.
        numbers: which of the trials, whose objects alternate; all by default.
        physics: resolution of the simulation.
    """
    chosen = range(world.trials) if numbers is None else numbers
    made = [_trial(name, design, world, seed, number, physics) for number in chosen]
    return sorted(made, key=lambda trial: (trial.shared.object, trial.shared.modulus_scale))


def _trial(
    name: str, design: Design, world: World, seed: int, number: int, physics: Physics
) -> DesignTrial:
    count = len(world.objects)
    place, turn = divmod(number, count)
    object_name = world.objects[(turn + seed) % count]
    of_object = np.random.default_rng([seed, zlib.crc32(object_name.encode())])
    of_place = np.random.default_rng([seed, zlib.crc32(f"{object_name}/{place}".encode())])
    dx, dy, yaw, mass, friction = of_place.uniform(-1.0, 1.0, 5).tolist()
    if world.at_ends:  # one scene serves the first half of the places, another the second
        modulus = world.modulus[2 * place >= world.places]
        friction_scale = world.friction[place % 2]
    else:
        modulus = float(of_object.uniform(*world.modulus))
        low, high = world.friction
        friction_scale = low + (high - low) * (friction + 1.0) / 2.0
    placement = Placement(
        (world.shift * dx, world.shift * dy),
        1.0 + world.mass * mass,
        world.yaw * yaw,
        friction_scale,
    )
    return DesignTrial(
        f"{name}/{number:02d}", Shared(design, object_name, modulus, physics), placement
    )


def success(records: Iterable[Mapping[str, Any]]) -> float:
    """Share of trials that gripped; one that ended in an error is a failure."""
    return float(np.mean([record.get("outcome") == OUTCOME_GRIPPED for record in records]))


def score(records: Sequence[Mapping[str, Any]]) -> float:
    """Score that a search maximises: mean success, plus a quarter of the mean of the worst quarter
    of the objects, plus LOST_COUNTS times the share of objects that were lost again.

    >>> held, none = {"object": "a", "outcome": "gripped"}, {"object": "b", "outcome": "none"}
    >>> score([held, held, none, none]), score([held])
    (0.5, 1.25)
    """
    by_object: dict[str, list[Mapping[str, Any]]] = {}
    for record in records:
        by_object.setdefault(record["object"], []).append(record)
    shares = sorted(map(success, by_object.values()))
    lost = float(np.mean([record.get("outcome") == OUTCOME_LOST for record in records]))
    return success(records) + WEIGHT * _worst(shares) + LOST_COUNTS * lost


def _worst(shares: Sequence[float]) -> float:
    """Mean of the lowest share WORST of sorted values; a value that lies partly in it counts in
    part.
    """
    counted = WORST * len(shares)
    weights = np.clip(counted - np.arange(len(shares)), 0.0, 1.0)
    return float(weights @ np.array(shares) / counted)
