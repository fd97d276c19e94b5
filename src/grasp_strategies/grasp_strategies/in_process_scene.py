"""The scene interface on a simulation in the same process, for trials in batches.

The only file of this package that imports pneuflex_sim. `ImposedAir` replaces the driver: the
chokes limit the flow, the smallest pulse is the resolution of a command, and a channel above its
pressure limit is relieved.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from grasp_strategies.judging.adaptability import Adaptability, TouchPoint, adaptability
from grasp_strategies.scene import PALM_PLATE, Array, Observation, SceneError, hand_body_names
from pneuflex_sim.hand.collision import SKIN_PATCH
from pneuflex_sim.hand.skin_places import SkinPlace, SkinPlaces
from pneuflex_sim.scene.friction import RUBBER_MATERIAL
from pneuflex_sim.simulation import Simulation, SimulationConfig
from pneuflex_sim.world import solver_settings
from softhand_common.numerics.compiled import compiled
from softhand_model.gas import (
    AMBIENT_PRESSURE,
    air_mass,
    line_conductance,
    orifice_conductance,
)
from softhand_model.pneumatics.air_flow import series_flow
from softhand_model.pneumatics.parameters import load_pneumatics

SMALLEST_PULSE = 2.5e-6  # air that one shortest opening of a valve moves (thesis 4.3) [kg]
WORTH_A_PULSE = 0.6  # of it, that have to lack for a pressure; half would take turns
RELIEF_END = 0.97  # of the limit, as the driver has it; the outlet closes again below it


class ImposedAir:
    """Air masses (channels,) [kg above the fill at rest] that follow commands: masses, or gauge
    pressures, which are then kept.

    A command is met to the nearest whole pulse. Until then a channel fills from the supply or
    empties to ambient through its choke and tube, at the mean of their tolerances. Like the driver,
    it empties a channel above its limit until the pressure is 3 % below, and does not fill it again
    before the next command.

    Args:
        limits: largest gauge pressures (channels,) [Pa].
        rest_volumes: volumes of the channels at rest (channels,) [m3].

    >>> air = ImposedAir(np.array([80e3]), np.array([3e-5]))
    >>> air.command(np.array([1.1e-5]))
    >>> for _ in range(1000):
    ...     masses = air.advance(0.001, np.array([120e3]))
    >>> round(1e6 * float(masses[0]), 3)
    10.0
    """

    def __init__(self, limits: Array, rest_volumes: Array) -> None:
        box = load_pneumatics()
        foil = float(np.mean(box.choke.discharge_coefficient)) * np.pi / 4
        chokes = np.array([box.choke.inlet_diameter, box.choke.outlet_diameter])
        self._inlet, self._outlet = orifice_conductance(foil * chokes**2, box.temperature).tolist()
        length = float(np.mean(box.line.length))
        self._line = float(line_conductance(box.line.diameter, length, box.temperature))
        self._ambient = box.ambient_pressure
        self._supply = box.supply.pressure + box.ambient_pressure
        self._limits = limits + box.ambient_pressure
        self._relief_ends = RELIEF_END * limits + box.ambient_pressure
        self._rest_masses = air_mass(box.ambient_pressure, rest_volumes, box.temperature)
        self.masses: Array = np.zeros(len(limits))
        self._goal: Array = np.zeros(len(limits))
        self._pressure_goal: Array = np.full(len(limits), np.nan)
        self.limited, self._relieving, self._blocked = np.zeros((3, len(limits)), bool)

    def command(self, masses: Array) -> None:
        """Set the masses (channels,) to reach [kg], NaN for a channel that keeps its command;
        raises ValueError unless there is one number per channel.
        """
        wanted = self._checked("air masses", masses)
        named = ~np.isnan(wanted)
        pulses = np.round(wanted / SMALLEST_PULSE)
        self._goal = np.where(named, pulses * SMALLEST_PULSE, self._goal)
        self._pressure_goal = np.where(named, np.nan, self._pressure_goal)
        self._blocked = np.where(named, self._relieving, self._blocked)

    def command_pressure(self, pressures: Array) -> None:
        """Set the gauge pressures (channels,) to reach and keep [Pa], NaN for a channel that keeps
        its command; raises ValueError as `command` does.
        """
        wanted = self._checked("pressures", pressures)
        named = ~np.isnan(wanted)
        self._pressure_goal = np.where(named, wanted, self._pressure_goal)
        self._blocked = np.where(named, self._relieving, self._blocked)

    def _checked(self, what: str, values: Array) -> Array:
        wanted = np.asarray(values, float)
        if wanted.shape != self.masses.shape or np.isinf(wanted).any():
            raise ValueError(
                f"{what}: expected {len(self.masses)} finite numbers, or NaN, got {values}"
            )
        return wanted

    def advance(self, duration: float, pressures_abs: Array) -> Array:
        """Masses (channels,) [kg] after `duration` [s] with the channels at absolute pressures
        (channels,) [Pa].
        """
        self.masses = _masses_after(
            duration,
            pressures_abs,
            (self.masses, self._rest_masses),
            (self._goal, self._pressure_goal),
            (self._limits, self._relief_ends),
            (self.limited, self._relieving, self._blocked),
            (self._supply, self._ambient),
            (self._inlet, self._outlet, self._line),
        )
        return self.masses


@compiled
def _masses_after(
    duration: float,
    pressures_abs: Array,
    masses: tuple[Array, Array],
    goals: tuple[Array, Array],
    limits: tuple[Array, Array],
    states: tuple[Array, Array, Array],
    outer: tuple[float, float],
    conductances: tuple[float, float, float],
) -> Array:
    """`ImposedAir.advance` on its arrays; goals and states are changed in place.

    For a commanded pressure, the goal is the air that is missing, to the nearest whole pulse,
    computed at the present volume of the channel: as the volume grows, no more air than is missing.
    """
    now, at_rest = masses
    goal, pressure_goal = goals
    limit, relief_end = limits
    limited, relieving, blocked = states
    supply, ambient = outer
    inlet, outlet, line = conductances
    after = now.copy()
    for i in range(len(now)):
        pressure = pressures_abs[i]
        if not math.isnan(pressure_goal[i]):
            capacity = (at_rest[i] + now[i]) / pressure  # V/(R_s T) [kg/Pa]
            wanted = now[i] + capacity * (pressure_goal[i] + ambient - pressure)
            if abs(wanted - goal[i]) > WORTH_A_PULSE * SMALLEST_PULSE:
                goal[i] = np.rint(wanted / SMALLEST_PULSE) * SMALLEST_PULSE
        if pressure > limit[i]:
            limited[i] = relieving[i] = blocked[i] = True
        relieving[i] = relieving[i] and pressure > relief_end[i]
        missing = -math.inf if relieving[i] else goal[i] - now[i]
        if missing > 0.0 and not blocked[i]:
            after[i] += min(missing, duration * series_flow(supply, pressure, inlet, line))
        elif missing < 0.0:
            after[i] += max(missing, -duration * series_flow(pressure, ambient, outlet, line))
    return after


@dataclass(frozen=True)
class SkinContact:
    """A contact point between two fingers of the hand: its place on each skin, and the normal force
    [N].
    """

    places: tuple[SkinPlace, SkinPlace]
    force: float


class InProcessScene:
    """`grasp_strategies.scene.Scene` on a `pneuflex_sim` simulation."""

    def __init__(self, simulation: Simulation) -> None:
        self.simulation = simulation
        self.channels: tuple[str, ...] = tuple(simulation.channels)
        self.hand_bodies = hand_body_names(chain.name for chain in simulation.hand.chains)
        self._air = self._air_at_rest()

    def _air_at_rest(self) -> ImposedAir:
        simulation = self.simulation
        return ImposedAir(simulation.hand.max_pressures(), simulation.air.rest_volumes)

    @property
    def time(self) -> float:
        """Simulated time [s]."""
        return float(self.simulation.time)

    def command_wrist(self, position: Array, orientation: Array) -> None:
        """Set the target pose of the wrist: position (3,) [m], quaternion (4,)."""
        self.simulation.command_wrist(position, orientation)

    def command_air(self, masses: Array) -> None:
        """Set the air masses (channels,) [kg above rest] to reach; NaN for a channel that keeps its
        command.
        """
        self._air.command(masses)

    def command_pressure(self, pressures: Array) -> None:
        """Command gauge pressures (channels,) [Pa], which are reached and then kept. A channel with
        NaN keeps its previous command.
        """
        self._air.command_pressure(pressures)

    def hold_object(self, position: Array, orientation: Array) -> None:
        """Put the object at a pose in the wrist frame, position (3,) [m] and quaternion (4,), and
        hold it there; raises ValueError for an invalid pose.
        """
        self.simulation.hold_object(position, orientation)

    def release_object(self, duration: float) -> None:
        """Let the spring that holds the object fade within a duration [s]."""
        self.simulation.release_object(duration)

    def vent(self) -> None:
        """Let the air out of all channels."""
        self._air.command(np.zeros(len(self.channels)))

    @property
    def limited(self) -> tuple[str, ...]:
        """Names of the channels that have exceeded their pressure limits and were relieved."""
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
        """The present state; it does not change while the simulation goes on."""
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
            simulation.touching_object(),
        )

    @cached_property
    def skin(self) -> SkinPlaces:
        """Places on the skin of fingers and thumb."""
        return SkinPlaces(self.simulation.shape)

    def finger_contacts(self) -> list[SkinContact]:
        """Contact points of fingers and thumb with each other, with their places on both skins.
        Contacts of neighbouring fingers need the field `finger_contact` of the simulation.
        """
        simulation, skin, q = self.simulation, self.skin, self.simulation.bodies.q
        position, orientation = simulation.wrist_pose()
        to_wrist = Rotation.from_quat(orientation).inv()
        found = []
        for contact in simulation.contacts():
            pair = contact.first, contact.second
            if set(pair) <= set(skin.chains):
                point = to_wrist.apply(np.array(contact.position) - position)
                first, second = (skin.locate(chain, point, q) for chain in pair)
                found.append(SkinContact((first, second), contact.force))
        return found

    def object_touches(self) -> list[TouchPoint]:
        """Contact points of the hand on the object. The patch of the skin of fingers, thumb and
        palm grows with the cube root of the normal force (Hertz); the plate has none.
        """
        config, thing = self.simulation.config, self.simulation.object
        if thing is None:
            return []
        table = self.simulation.friction
        friction = config.friction_scale * table.pair(RUBBER_MATERIAL, thing.material)
        return [
            TouchPoint(
                contact.first,
                contact.segment,
                contact.position,
                tuple(-np.array(contact.normal)),
                friction,
                0.0 if contact.first == PALM_PLATE else SKIN_PATCH * contact.force ** (1.0 / 3.0),
            )
            for contact in self.simulation.object_contacts()
            if contact.first in self.hand_bodies and contact.force > 0.0
        ]

    def adaptability(self) -> Adaptability:
        """How the hand touches the object now; torques about the origin of the object's axes, over
        half the diagonal of the box around it. Raises ValueError in a scene without object.
        """
        place, _ = self.simulation.object_pose()
        thing = self.simulation.object
        length = np.linalg.norm(thing.half_sizes) if thing else 0.0
        return adaptability(self.object_touches(), place, float(length))

    def save(self) -> dict[str, Any]:
        """State of the simulation, for `restart`."""
        return self.simulation.save()

    def restart(
        self,
        saved: dict[str, Any],
        offset: tuple[float, ...],
        mass_scale: float,
        yaw: float = 0.0,
        friction_scale: float = 1.0,
    ) -> None:
        """Go back to a snapshot from before anything was commanded, with the object shifted by
        `offset` [m], turned by `yaw` [rad], its mass and the friction of all pairs scaled. The
        simulation then continues exactly like a new one, bit for bit.
        """
        self.simulation.restore(saved)
        self.simulation.place_object(offset, mass_scale, yaw, friction_scale)
        self._air = self._air_at_rest()

    def close(self) -> None:
        """Free the simulation."""
        self.simulation.close()


def build_scene(*, solver: str = "default", **config: Any) -> InProcessScene:
    """A new scene, from the fields of `SimulationConfig` and the name of the solver's settings;
    raises ValueError for names that do not exist.
    """
    return InProcessScene(Simulation(SimulationConfig(solver=solver_settings(solver), **config)))
