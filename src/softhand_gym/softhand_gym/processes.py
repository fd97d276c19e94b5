"""Several environments at once, each in a process of its own."""

from __future__ import annotations

from functools import partial
from typing import Any

from gymnasium.vector import AsyncVectorEnv

from softhand_gym.environment import GraspEnv


def in_processes(num_envs: int = 1, **settings: Any) -> AsyncVectorEnv:
    """So many environments with the settings of `GraspEnv`, which `gymnasium.make_vec` makes.

    The processes are spawned, as PyBullet does not bear a fork: a script that calls this needs
    `if __name__ == "__main__":`.
    """
    return AsyncVectorEnv([partial(GraspEnv, **settings)] * num_envs, context="spawn")
