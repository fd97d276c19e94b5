"""The scene contract on a simulation in the same process, for trials in batches.

The only file of this package that imports pneuflex_sim.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from grasp_strategies.imposed_air import ImposedAir
from grasp_strategies.scene import Array, Observation, SceneError, hand_body_names
from pneuflex_sim.simulation import Simulation, SimulationConfig
from pneuflex_sim.solver import solver_settings
from softhand_model.gas import AMBIENT_PRESSURE

OBJECT = "object"


class InProcessScene:
    """`grasp_strategies.scene.Scene` over a `pneuflex_sim` simulation."""

    def __init__(self, simulation: Simulation) -> None:
        self._simulation = simulation
        self.channels: tuple[str, ...] = tuple(simulation.channels)
        self.hand_bodies = hand_body_names(chain.name for chain in simulation.hand.chains)
        self._air = self._new_air()

    def _new_air(self) -> ImposedAir:
        return ImposedAir(self._simulation.hand.max_pressures())

    @property
    def simulation(self) -> Simulation:
        """What runs behind the contract, to be looked at: strategies do not see it."""
        return self._simulation

    @property
    def time(self) -> float:
        """Simulated time [s]."""
        return float(self._simulation.time)

    def command_wrist(self, position: Array, orientation: Array) -> None:
        """Set the target pose of the wrist: position (3,) [m], quaternion (4,)."""
        self._simulation.command_wrist(position, orientation)

    def command_air(self, masses: Array) -> None:
        """Set the air masses (channels,) [kg above rest] to reach."""
        self._air.command(masses)

    def vent(self) -> None:
        """Let all air out."""
        self._air.command(np.zeros(len(self.channels)))

    @property
    def limited(self) -> tuple[str, ...]:
        """Names of the channels that have been above their pressure limits, and were relieved."""
        pairs = zip(self.channels, self._air.limited, strict=True)
        return tuple(name for name, limited in pairs if limited)

    def step(self, duration: float) -> None:
        """Simulate `duration` [s], in whole physics steps, at least one.

        Raises SceneError when the simulation diverges.
        """
        simulation, step = self._simulation, self._simulation.step_size
        for _ in range(max(1, round(duration / step))):
            pressures_abs = simulation.pressures() + AMBIENT_PRESSURE
            simulation.set_air_masses(self._air.advance(step, pressures_abs))
            try:
                simulation.step()
            except RuntimeError as error:
                raise SceneError(str(error)) from error

    def observe(self) -> Observation:
        """Return the state now."""
        simulation = self._simulation
        wrist, wrist_turn = simulation.wrist_pose()
        place, turn = simulation.object_pose()
        return Observation(
            self.time,
            wrist,
            wrist_turn,
            simulation.wrist_wrench()[0],
            place,
            turn,
            self._air.masses,
            simulation.pressures(),
            frozenset(
                body
                for contact in simulation.object_contacts()
                for body in (contact.first, contact.second)
                if body != OBJECT
            ),
        )

    def save(self) -> dict[str, Any]:
        """Snapshot for `restart`."""
        return self._simulation.save()

    def restart(self, saved: dict[str, Any], offset: tuple[float, ...], mass_scale: float) -> None:
        """Go back to a snapshot from before anything was commanded, with the object shifted by
        `offset` [m] and its mass scaled; the same, bit for bit, as in a new simulation.
        """
        self._simulation.restore(saved)
        self._simulation.place_object(offset, mass_scale)
        self._air = self._new_air()

    def close(self) -> None:
        """Free the simulation."""
        self._simulation.close()


def build_scene(*, solver: str = "default", **config: Any) -> InProcessScene:
    """A new simulation behind the contract, by the fields of `SimulationConfig` and the name of the
    solver's settings; raises ValueError for names that do not exist.
    """
    return InProcessScene(Simulation(SimulationConfig(solver=solver_settings(solver), **config)))
