"""Frames: the visible state of a hand at one instant, and runs as sequences of frames."""

from __future__ import annotations

from collections.abc import MutableSequence
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from pneuflex_sim.hand.air import AirCoupling
from pneuflex_sim.hand.layout import HandLayout
from pneuflex_sim.pictures.render import HandState
from pneuflex_sim.pictures.surfaces import total_arrow
from pneuflex_sim.scene.contacts import by_pair
from pneuflex_sim.scene.objects import ObjectDescription
from pneuflex_sim.scene.scenes import SceneDescription
from pneuflex_sim.simulation import Simulation
from softhand_common.numerics.arrays import Array
from softhand_model.gas import AMBIENT_PRESSURE, GAS_CONSTANT, ROOM_TEMPERATURE
from softhand_trials.trials import Placement, TrialSettings

INTERVAL = 0.04  # simulated time between frames [s]
NO_ARROWS = np.zeros((0, 2, 3))


@dataclass(frozen=True)
class Frame:
    """State at one instant: time [s], joints and poses, gauge pressures [Pa], air masses [kg above
    rest] and volumes [m3] of the channels (channels,), an arrow (k, 2, 3) [m], start and end, for
    the force of each of k pairs of bodies in contact, and the phase of the strategy.
    """

    time: float
    state: HandState
    pressures: Array
    masses: Array
    volumes: Array
    arrows: Array
    phase: str = ""


@dataclass(frozen=True)
class StaticScene:
    """What stays the same in a run: layout of the hand, object (or None) and surroundings."""

    layout: HandLayout
    object: ObjectDescription | None
    scene: SceneDescription

    @property
    def channels(self) -> tuple[str, ...]:
        """Names of the hand's channels."""
        return tuple(self.layout.description.channels)

    @cached_property
    def _rest_volumes(self) -> Array:
        return AirCoupling(self.layout).rest_volumes

    def volumes(self, masses: Array, pressures: Array) -> Array:
        """Volumes (channels,) [m3] that air masses (channels,) [kg above rest] fill at gauge
        pressures (channels,) [Pa], as an ideal gas at room temperature.
        """
        above = masses * GAS_CONSTANT * ROOM_TEMPERATURE
        return (self._rest_volumes * AMBIENT_PRESSURE + above) / (pressures + AMBIENT_PRESSURE)


@dataclass(frozen=True)
class World:
    """A trial to simulate: settings, where the object is placed, and what stored results say of its
    outcome ("" if there are none).
    """

    settings: TrialSettings = field(default_factory=TrialSettings)
    placement: Placement = field(default_factory=Placement)
    known_outcome: str = ""


@dataclass(frozen=True)
class Track:
    """A run: frames in steps of INTERVAL [s], the static scene, and the result in words."""

    frames: MutableSequence[Frame]
    static_scene: StaticScene
    ending: str = ""

    @property
    def phases(self) -> dict[str, int]:
        """Index of the first frame of each phase."""
        found: dict[str, int] = {}
        for number, frame in enumerate(self.frames):
            found.setdefault(frame.phase, number)
        return {name: number for name, number in found.items() if name}


def static_scene_of(simulation: Simulation) -> StaticScene:
    """What stays the same while a simulation runs."""
    return StaticScene(simulation.shape.layout, simulation.object, simulation.scene)


def frame_of(simulation: Simulation, phase: str = "") -> Frame:
    """The current frame of a simulation, as a copy."""
    pose = simulation.object_pose() if simulation.object is not None else ()
    seen = simulation.bodies.q, *simulation.wrist_pose(), *pose
    state = HandState(*(np.array(part) for part in seen))
    pairs = by_pair(simulation.contacts()).values()
    return Frame(
        float(simulation.time),
        state,
        np.array(simulation.pressures()),
        np.array(simulation.air_masses()),
        simulation.air.volumes(simulation.bodies.rotations),
        np.array([total_arrow(contacts) for contacts in pairs]).reshape(-1, 2, 3),
        phase,
    )
