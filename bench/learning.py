"""How fast the learning environment is: over the bare scene, and two processes over one.

A grasp of the cylinder is recorded once as actions, and run again in turns: by the environment, and
by the scene alone, which gets the same commands, steps as long and observes once an action.
"""

from __future__ import annotations

import time
from typing import Any

import gymnasium
import numpy as np

from bench.row import at_least, stated
from grasp_strategies.pose import Pose
from softhand_gym import ENVIRONMENT_ID, GraspEnv
from softhand_gym.replay import replay

SEED = 1
TURNS = 5
PER_PROCESS = 150  # actions of a recorded grasp that every process runs


def run() -> list[dict[str, Any]]:
    """Ratios of actions a second; processor time in one process, wall time with several."""
    env = GraspEnv()
    actions = replay(env, "surface_constrained", SEED).actions
    targets = _targets(env, actions)
    turns = [(_bare(env, actions, targets), _acting(env, actions)) for _ in range(TURNS)]
    bare, acting = np.median(turns, axis=0)
    env.close()
    one, two = (_in_processes(count, actions[:PER_PROCESS]) for count in (1, 2))
    return [
        stated("actions a second of processor time, one environment", len(actions) / acting, ""),
        at_least("environment over the bare scene, actions a second", bare / acting, "", 0.9),
        at_least("actions a second, two processes over one", 2 * one / two, "", 1.8),
    ]


def _acting(env: GraspEnv, actions: list[Any]) -> float:
    """Processor time [s] of an episode."""
    env.reset(seed=SEED)
    begin = time.process_time()
    for action in actions:
        env.step(action)
    return time.process_time() - begin


def _bare(env: GraspEnv, actions: list[Any], targets: list[Pose]) -> float:
    """Processor time [s] of the scene alone under the commands of an episode."""
    env.reset(seed=SEED)
    scene = env.scene
    begin = time.process_time()
    for action, target in zip(actions, targets, strict=True):
        env.air.command(scene, action[:-6])
        scene.command_wrist(target.position, target.orientation)
        scene.step(env.action_time)
        scene.observe()
    return time.process_time() - begin


def _targets(env: GraspEnv, actions: list[Any]) -> list[Pose]:
    """The wrist's target at the end of each action."""
    env.reset(seed=SEED)
    found = []
    for action in actions:
        env.step(action)
        found.append(env.target)
    return found


def _in_processes(count: int, actions: list[Any]) -> float:
    """Least wall time [s] in which so many processes run the actions."""
    envs = gymnasium.make_vec(ENVIRONMENT_ID, num_envs=count)
    times = []
    try:
        for _ in range(TURNS):
            envs.reset(seed=[SEED] * count)
            begin = time.perf_counter()
            for action in actions:
                envs.step(np.stack([action] * count))
            times.append(time.perf_counter() - begin)
    finally:
        envs.close()
    return min(times)
