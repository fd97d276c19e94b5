"""What a learned policy of the cylinder is worth: beside actions at random, the shipped strategy,
and a policy that learned from shuffled returns, on seeds that none of them has seen.

Both trainings are those of `examples/learn_a_grasp.py`, as kept in `examples/learned_grasp.json`.
Criteria, budget and seeds were committed before they ran; until then policies at random and a grid
of places with about the shipped air were tried, on seeds below 50, to choose where a training
starts.
"""

from __future__ import annotations

import multiprocessing
import warnings
from concurrent.futures import ProcessPoolExecutor
from typing import Any

import numpy as np

from bench.row import at_least, at_most, stated
from examples.learn_a_grasp import GoCloseLift, Random, episode, load
from softhand_gym import GraspEnv
from softhand_gym.replay import replay

SEED = 2  # of both trainings
SEEDS = range(5000, 5100)  # of episodes to compare; trainings draw theirs from 10,000 on
SETTINGS = {"engine": "mujoco", "step": 0.005, "action_time": 0.1}
BUDGET = 1200.0  # processor time of a training, ten minutes of two cores [s]
ADVANTAGE = 50  # grasps of 100 that the learned policy must have more than random actions
CHANCE = 5  # and that the one from shuffled returns may have more
STRATEGY = "surface_constrained"
LEARNED, SHUFFLED, RANDOM = "learned", "shuffled", "random"


def rows() -> list[dict[str, Any]]:
    """Grasps of 100 seeds of each policy, and what training took."""
    spawned = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(2, spawned) as pool:
        kinds = (LEARNED, SHUFFLED, RANDOM, STRATEGY)
        found = dict(zip(kinds, zip(*pool.map(_grasps, SEEDS), strict=True), strict=True))
    grasps = {kind: int(np.sum(won)) for kind, won in found.items()}
    spent = max(load(kind).seconds[-1] for kind in (LEARNED, SHUFFLED))
    words = f"grasps of {len(SEEDS)} fresh seeds"
    return [
        *(stated(f"{words}, {kind}", count, "") for kind, count in grasps.items()),
        at_least(f"{words}, learned above random", grasps[LEARNED] - grasps[RANDOM], "", ADVANTAGE),
        at_most(f"{words}, shuffled above random", grasps[SHUFFLED] - grasps[RANDOM], "", CHANCE),
        at_most("processor time of a training", spent, "s", BUDGET),
    ]


def _grasps(seed: int) -> tuple[bool, ...]:
    """Whether the object is held at the end of an episode, by policy."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)  # joints at their stops
        env = GraspEnv(**SETTINGS)
        learned, shuffled = (GoCloseLift(load(kind).numbers) for kind in (LEARNED, SHUFFLED))
        policies = (learned, shuffled, Random(env.action_space, seed))
        infos = [episode(env, policy, seed)[1] for policy in policies]
        infos.append(replay(env, STRATEGY, seed).info)
    env.close()
    return tuple(bool(info["is_success"]) for info in infos)
