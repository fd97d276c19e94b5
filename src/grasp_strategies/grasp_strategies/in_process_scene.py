"""The scene contract on a simulation in the same process, for trials in batches.

The only file of this package that imports pneuflex_sim. `ImposedAir` stands in for the driver: the
chokes limit the rate, the smallest pulse is the grain of what can be commanded, and a channel above
its pressure limit is relieved.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from grasp_strategies.scene import Array, Observation, SceneError, hand_body_names
from pneuflex_sim.scene.contacts import OBJECT
from pneuflex_sim.simulation import Simulation, SimulationConfig
from pneuflex_sim.world import solver_settings
from softhand_model.gas import AMBIENT_PRESSURE, line_conductance, orifice_conductance, series_flow
from softhand_model.pneumatics.parameters import Pneumatics, load_pneumatics

SMALLEST_PULSE = 2.5e-6  # air that one shortest opening of a valve moves (thesis 4.3) [kg]
RELIEF_END = 0.97  # of the limit, as the driver has it; the outlet closes again below it


class ImposedAir:
    """Air masses (channels,) [kg above the fill at rest] on their way to the commanded ones.

    A command is met to the nearest whole pulse. Until then a channel fills from the supply or
    empties to ambient through its choke and tube (mean of their tolerances). As the driver does, it
    empties a channel above its limit until the pressure is 3 % below, and does not fill it again
    before the next command.

    Args:
        limits: largest gauge pressures (channels,) [Pa].
        parameters: of the box.

    >>> air = ImposedAir(np.array([80e3]))
    >>> air.command(np.array([1.1e-5]))
    >>> for _ in range(1000):
    ...     masses = air.advance(0.001, np.array([120e3]))
    >>> round(1e6 * float(masses[0]), 3)
    10.0
    """

    def __init__(self, limits: Array, parameters: Pneumatics | None = None) -> None:
        box = parameters or load_pneumatics()
        foil = float(np.mean(box.choke.discharge_coefficient)) * np.pi / 4
        self._inlet = orifice_conductance(foil * box.choke.inlet_diameter**2, box.temperature)
        self._outlet = orifice_conductance(foil * box.choke.outlet_diameter**2, box.temperature)
        self._line = line_conductance(
            box.line.diameter, float(np.mean(box.line.length)), box.temperature
        )
        self._ambient = box.ambient_pressure
        self._supply = box.supply.pressure + box.ambient_pressure
        self._limits = limits + box.ambient_pressure
        self._relief_ends = RELIEF_END * limits + box.ambient_pressure
        self.masses: Array = np.zeros(len(limits))
        self._goal: Array = np.zeros(len(limits))
        self.limited, self._relieving, self._blocked = np.zeros((3, len(limits)), bool)

    def command(self, masses: Array) -> None:
        """Set the masses to reach [kg]; raises ValueError unless there is one number a channel."""
        wanted = np.asarray(masses, float)
        if wanted.shape != self.masses.shape or not np.isfinite(wanted).all():
            raise ValueError(
                f"air masses: expected {len(self.masses)} finite numbers, got {masses}"
            )
        self._goal = np.round(wanted / SMALLEST_PULSE) * SMALLEST_PULSE
        self._blocked = self._relieving.copy()

    def advance(self, duration: float, pressures_abs: Array) -> Array:
        """Masses [kg] after `duration` [s] with the channels at absolute pressures [Pa]."""
        missing = self._allowed(pressures_abs)
        if missing.any():
            self.masses = self.masses + np.clip(
                missing,
                -duration * series_flow(pressures_abs, self._ambient, self._outlet, self._line),
                duration * series_flow(self._supply, pressures_abs, self._inlet, self._line),
            )
        return self.masses

    def _allowed(self, pressures_abs: Array) -> Array:
        """Air (channels,) [kg] that is wanted and that the limits do not forbid; a channel that is
        relieved loses what it can.
        """
        over = pressures_abs > self._limits
        if over.any():
            self.limited |= over
            self._relieving |= over
            self._blocked |= over
        missing = self._goal - self.masses
        if not self._blocked.any():
            return missing
        self._relieving &= pressures_abs > self._relief_ends
        held = np.where(self._blocked, np.minimum(missing, 0.0), missing)
        return np.where(self._relieving, -np.inf, held)


class InProcessScene:
    """`grasp_strategies.scene.Scene` over a `pneuflex_sim` simulation; strategies do not see what
    runs behind it.
    """

    def __init__(self, simulation: Simulation) -> None:
        self.simulation = simulation
        self.channels: tuple[str, ...] = tuple(simulation.channels)
        self.hand_bodies = hand_body_names(chain.name for chain in simulation.hand.chains)
        self._air = ImposedAir(simulation.hand.max_pressures())

    @property
    def time(self) -> float:
        """Simulated time [s]."""
        return float(self.simulation.time)

    def command_wrist(self, position: Array, orientation: Array) -> None:
        """Set the target pose of the wrist: position (3,) [m], quaternion (4,)."""
        self.simulation.command_wrist(position, orientation)

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
        simulation, step = self.simulation, self.simulation.step_size
        for _ in range(max(1, round(duration / step))):
            pressures_abs = simulation.pressures() + AMBIENT_PRESSURE
            simulation.set_air_masses(self._air.advance(step, pressures_abs))
            try:
                simulation.step()
            except RuntimeError as error:
                raise SceneError(str(error)) from error

    def observe(self) -> Observation:
        """Return the state now; it stays as it is while the simulation goes on."""
        simulation = self.simulation
        wrist_position, wrist_orientation = simulation.wrist_pose()
        return Observation(
            self.time,
            wrist_position.copy(),
            wrist_orientation.copy(),
            simulation.wrist_wrench()[0].copy(),
            *simulation.object_pose(),
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
        return self.simulation.save()

    def restart(self, saved: dict[str, Any], offset: tuple[float, ...], mass_scale: float) -> None:
        """Go back to a snapshot from before anything was commanded, with the object shifted by
        `offset` [m] and its mass scaled; the same, bit for bit, as in a new simulation.
        """
        self.simulation.restore(saved)
        self.simulation.place_object(offset, mass_scale)
        self._air = ImposedAir(self.simulation.hand.max_pressures())

    def close(self) -> None:
        """Free the simulation."""
        self.simulation.close()


def build_scene(*, solver: str = "default", **config: Any) -> InProcessScene:
    """A new simulation behind the contract, by the fields of `SimulationConfig` and the name of the
    solver's settings; raises ValueError for names that do not exist.
    """
    return InProcessScene(Simulation(SimulationConfig(solver=solver_settings(solver), **config)))
