"""Physics engines: the interface that each of them has (`contract`), and a package or module for
each.

An engine is imported when a simulation asks for it, so that the other one need not be installed.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from pneuflex_sim.bullet import NO_PYBULLET, NotInstalled, is_installed

if TYPE_CHECKING:
    from pneuflex_sim.engines.contract import Engine, Surroundings

PYBULLET, MUJOCO = "pybullet", "mujoco"
ENGINES = (PYBULLET, MUJOCO)
NO_MUJOCO = (
    "mujoco: expected it to be installed, got none; `pip install mujoco-core`, or take engine "
    "pybullet"
)


def default_engine() -> str:
    """PyBullet where it is installed, else MuJoCo."""
    return PYBULLET if is_installed() or not is_installed(MUJOCO) else MUJOCO


def check_engine(name: str) -> None:
    """Raise ValueError unless `name` is the name of an engine."""
    if name not in ENGINES:
        raise ValueError(f"engine: expected one of {', '.join(ENGINES)}, got {name!r}")


def check_installed(name: str) -> None:
    """Raise NotInstalled for an engine that is not installed; its message says what to do."""
    if name == PYBULLET and not is_installed():
        raise NotInstalled(NO_PYBULLET)
    if name == MUJOCO and not is_installed(MUJOCO):
        raise NotInstalled(NO_MUJOCO)


def check_engines(names: Sequence[str]) -> None:
    """Raise ValueError unless these are names of one or more different engines, and NotInstalled
    for an engine that is not installed.
    """
    if not names or len(set(names)) < len(names):
        raise ValueError(
            f"engines: expected one or more different names, got {', '.join(names) or 'none'}"
        )
    for name in names:
        check_engine(name)
        check_installed(name)


def build_engine(name: str, around: Surroundings) -> Engine:
    """The engine of that name with hand, object and scene in it.

    Raises ValueError for what this engine cannot simulate, NotInstalled when it is not installed.
    """
    check_engine(name)
    check_installed(name)
    if name == PYBULLET:
        from pneuflex_sim.engines.pybullet_engine import PybulletEngine

        return PybulletEngine(around)
    from pneuflex_sim.engines.mujoco.engine import MujocoEngine

    return MujocoEngine(around)
