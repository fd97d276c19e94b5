"""How fast the learning environment is, over the bare scene and in two processes over one, and what
a small policy learns in it.

A grasp of the cylinder is recorded once as actions, and run again in turns: by the environment, and
by the scene alone, which gets the same commands, steps as long and observes once an action.
"""

from __future__ import annotations

import time
from typing import Any

import gymnasium
import numpy as np
import psutil
from gymnasium.utils.env_checker import check_env

from bench import learned_grasp
from bench.row import at_least, stated
from grasp_strategies.pose import Pose
from softhand_gym import ENVIRONMENT_ID, GraspEnv
from softhand_gym.replay import replay

SEED = 1
TURNS = 5
PER_PROCESS = 150  # actions of a recorded grasp that every process runs


def run() -> list[dict[str, Any]]:
    """Ratios of actions a second, in processor time and, of processes, also in wall time."""
    env = GraspEnv()
    passes = _passes(env)
    actions = replay(env, "surface_constrained", SEED).actions
    targets = _targets(env, actions)
    turns = [(_bare(env, actions, targets), _acting(env, actions)) for _ in range(TURNS)]
    bare, acting = np.median(turns, axis=0)
    env.close()
    (wall, spent), (wall_of_two, spent_of_two) = (
        _in_processes(count, actions[:PER_PROCESS]) for count in (1, 2)
    )
    return [
        at_least("check_env passes", passes, "", 1),
        stated("actions a second of processor time, one environment", len(actions) / acting, ""),
        at_least("environment over the bare scene, actions a second", bare / acting, "", 0.9),
        at_least("actions a second, two processes over one", 2 * wall / wall_of_two, "", 1.8),
        stated("the same by processor time: without waiting", 4 * spent / spent_of_two, ""),
        *learned_grasp.rows(),
    ]


def _passes(env: GraspEnv) -> bool:
    """Whether Gymnasium's checker finds nothing wrong."""
    try:
        check_env(env, skip_render_check=True)
    except AssertionError as error:
        print(f"  check_env: {error}", flush=True)
        return False
    return True


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


def _in_processes(count: int, actions: list[Any]) -> tuple[float, float]:
    """Least wall time and least processor time of all [s] in which so many processes run the
    actions.
    """
    envs = gymnasium.make_vec(ENVIRONMENT_ID, num_envs=count)
    wall, spent = [], []
    try:
        for _ in range(TURNS):
            envs.reset(seed=[SEED] * count)
            begin, before = time.perf_counter(), _spent()
            for action in actions:
                envs.step(np.stack([action] * count))
            wall.append(time.perf_counter() - begin)
            spent.append(_spent() - before)
    finally:
        envs.close()
    return min(wall), min(spent)


def _spent() -> float:
    """Processor time so far of the processes that this one has started [s]."""
    times = [process.cpu_times() for process in psutil.Process().children()]
    return sum(time.user + time.system for time in times)
