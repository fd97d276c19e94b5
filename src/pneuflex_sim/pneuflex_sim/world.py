"""A PyBullet world of its own client, with the settings of its contact solver (Table 5.1).

The thesis' solver stops at a precision (1e-2, 1e-4, 1e-5) or after a number of iterations (100,
500, 2000) and over-relaxes (1.5, 1.3, 1.0). PyBullet's stops at a residual of velocities or after
its iterations, and does not over-relax; it starts from the impulses of the step before, so it needs
fewer. docs/understand/simulator-steps.md tabulates what the settings do to a grasp.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pneuflex_sim.bullet import pybullet


class Diverged(RuntimeError):
    """A body moves impossibly fast, or its position is not finite; the simulation needs a reset."""


@dataclass(frozen=True)
class SolverSettings:
    """Largest number of iterations per step, and the residual that ends them early: the sum of
    squared velocities [m2/s2].

    Raises ValueError for fewer than one iteration or a residual below zero.
    """

    iterations: int = 30
    residual: float = 1e-7

    def __post_init__(self) -> None:
        if self.iterations < 1:
            raise ValueError(f"iterations: expected 1 or more, got {self.iterations}")
        if not self.residual >= 0:
            raise ValueError(f"residual: expected 0 or more, got {self.residual}")


SOLVER_SETTINGS = {
    "fast": SolverSettings(15, 1e-4),
    "default": SolverSettings(),
    "stable": SolverSettings(100, 0.0),
}


def solver_settings(name: str) -> SolverSettings:
    """The settings of that name; raises ValueError listing the available names.

    >>> solver_settings("stable").iterations
    100
    """
    if name not in SOLVER_SETTINGS:
        raise ValueError(f"solver: expected one of {', '.join(SOLVER_SETTINGS)}; got {name!r}")
    return SOLVER_SETTINGS[name]


class BulletState:
    """A saved state of a world's bodies; PyBullet's memory of it is freed with this object."""

    def __init__(self, world: World) -> None:
        self._world = world
        self._id: int = pybullet.saveState(physicsClientId=world.client)

    def restore(self) -> None:
        """Bring the world back to the state."""
        pybullet.restoreState(stateId=self._id, physicsClientId=self._world.client)

    def __del__(self) -> None:
        if not self._world.closed:
            pybullet.removeState(self._id, physicsClientId=self._world.client)


class World:
    """One physics client. Every call names the client, so several worlds can live in one process.

    Friction is limited by a cone. PyBullet's default, a pyramid around it, is 1.41 times as strong
    between its axes, and resists no twisting.
    """

    def __init__(
        self, step: float, gui: bool = False, settings: SolverSettings | None = None
    ) -> None:
        settings = settings or SolverSettings()
        self.step_size = step
        self.broken = False  # NaN stays in the engine's collision detection, even after a reset
        self.client = pybullet.connect(pybullet.GUI if gui else pybullet.DIRECT)
        self.closed = False
        if self.client < 0:
            raise RuntimeError("PyBullet refused a new client: with gui it needs a display")
        if gui:
            self._look_at_the_hand()
        pybullet.setTimeStep(step, physicsClientId=self.client)
        pybullet.setPhysicsEngineParameter(
            numSolverIterations=settings.iterations,
            solverResidualThreshold=settings.residual,
            deterministicOverlappingPairs=1,
            enableFileCaching=0,
            collisionFilterMode=0,  # two bodies touch where the masks of both allow it
            enableConeFriction=1,
            physicsClientId=self.client,
        )

    def boxes(self, links: list[tuple[int, int]]) -> NDArray[np.float64]:
        """Corners (k, 2, 3) [m] of the boxes along the world's axes around links (body, link)."""
        return np.array(
            [pybullet.getAABB(body, link, physicsClientId=self.client) for body, link in links]
        )

    def diverged(self, reason: str) -> Diverged:
        """The error to raise. A world that has diverged cannot be used any more, even after a
        reset.
        """
        self.broken = True
        return Diverged(reason)

    def _look_at_the_hand(self) -> None:
        """Move the window's camera close to the hand, and hide PyBullet's own panels."""
        pybullet.configureDebugVisualizer(pybullet.COV_ENABLE_GUI, 0, physicsClientId=self.client)
        pybullet.resetDebugVisualizerCamera(
            cameraDistance=0.45,
            cameraYaw=35,
            cameraPitch=-20,
            cameraTargetPosition=[0, 0, 0.12],
            physicsClientId=self.client,
        )

    def close(self) -> None:
        """Disconnect; the world cannot be used after that."""
        self.closed = True
        if pybullet.isConnected(self.client):
            pybullet.disconnect(self.client)
