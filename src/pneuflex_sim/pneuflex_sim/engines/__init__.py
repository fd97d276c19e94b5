"""Physics engines: what each must give (`contract`), and one room for each of them.

An engine is loaded when a simulation asks for it, so that the other need not be installed.
"""

from __future__ import annotations

from importlib.util import find_spec
from typing import TYPE_CHECKING

from pneuflex_sim.bullet import is_installed

if TYPE_CHECKING:
    from pneuflex_sim.engines.contract import Engine, Surroundings

PYBULLET, MUJOCO = "pybullet", "mujoco"
ENGINES = (PYBULLET, MUJOCO)


def default_engine() -> str:
    """PyBullet where it is installed, else MuJoCo."""
    return PYBULLET if is_installed() or find_spec(MUJOCO) is None else MUJOCO


def check_engine(name: str) -> None:
    """Raise ValueError for anything but the name of an engine."""
    if name not in ENGINES:
        raise ValueError(f"engine: expected one of {', '.join(ENGINES)}, got {name!r}")


def build_engine(name: str, around: Surroundings) -> Engine:
    """The engine of that name with hand, object and scene in it.

    Raises ValueError for what this engine cannot simulate, RuntimeError where it is not installed.
    """
    check_engine(name)
    if name == PYBULLET:
        from pneuflex_sim.engines.pybullet_engine import PybulletEngine

        return PybulletEngine(around)
    if find_spec(MUJOCO) is None:
        raise RuntimeError(
            "mujoco: expected it to be installed, got none; `pip install mujoco-core`"
        )
    from pneuflex_sim.engines.mujoco.engine import MujocoEngine

    return MujocoEngine(around)
