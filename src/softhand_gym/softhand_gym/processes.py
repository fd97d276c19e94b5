"""Several environments at once, each in its own process."""

from __future__ import annotations

from functools import partial
from typing import Any

from gymnasium.vector import AsyncVectorEnv

from softhand_gym.environment import GraspEnv


def in_processes(num_envs: int = 1, **settings: Any) -> AsyncVectorEnv:
    """`num_envs` environments with the arguments of `GraspEnv`, each in a process of its own;
    `gymnasium.make_vec` uses this function.

    The processes are spawned, as PyBullet does not work after a fork: a script that calls this
    needs `if __name__ == "__main__":`.
    """
    return AsyncVectorEnv([partial(GraspEnv, **settings)] * num_envs, context="spawn")
