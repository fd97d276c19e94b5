"""What is to be seen of a hand at one instant, and a run as a row of such instants."""

from __future__ import annotations

from collections.abc import MutableSequence
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from grasp_strategies.trials import Placement, TrialSettings
from pneuflex_sim.hand.air import AirCoupling
from pneuflex_sim.hand.layout import HandLayout
from pneuflex_sim.pictures.render import HandState
from pneuflex_sim.pictures.surfaces import total_arrow
from pneuflex_sim.scene.contacts import by_pair
from pneuflex_sim.scene.objects import ObjectDescription
from pneuflex_sim.scene.scenes import SceneDescription
from pneuflex_sim.simulation import Simulation
from softhand_model.gas import AMBIENT_PRESSURE, GAS_CONSTANT, ROOM_TEMPERATURE

Array = NDArray[np.float64]

INTERVAL = 0.04  # simulated time between instants [s]
NO_ARROWS = np.zeros((0, 2, 3))


@dataclass(frozen=True)
class Shot:
    """One instant: time [s], joints and poses, gauge pressures [Pa], air masses [kg above rest] and
    volumes [m3] of the channels, an arrow (k, 2, 3) [m] of the force of each pair that touches, and
    the phase of a strategy.
    """

    time: float
    state: HandState
    pressures: Array
    masses: Array
    volumes: Array
    arrows: Array
    phase: str = ""


@dataclass(frozen=True)
class Stage:
    """What does not move: the hand's layout, the object (or None) and what stands around."""

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
        """Volumes (channels,) [m3] that air masses [kg above rest] take at gauge pressures [Pa]."""
        above = masses * GAS_CONSTANT * ROOM_TEMPERATURE
        return (self._rest_volumes * AMBIENT_PRESSURE + above) / (pressures + AMBIENT_PRESSURE)


@dataclass(frozen=True)
class World:
    """What is simulated, as a trial has it, and the outcome that results have of it, if any."""

    settings: TrialSettings = field(default_factory=TrialSettings)
    placement: Placement = field(default_factory=Placement)
    known: str = ""


@dataclass(frozen=True)
class Track:
    """Instants in steps of `INTERVAL` on a stage, and how they ended."""

    shots: MutableSequence[Shot]
    stage: Stage
    ending: str = ""

    @property
    def phases(self) -> dict[str, int]:
        """Number of the first instant of each phase."""
        found: dict[str, int] = {}
        for number, shot in enumerate(self.shots):
            found.setdefault(shot.phase, number)
        return {name: number for name, number in found.items() if name}


def stage_of(simulation: Simulation) -> Stage:
    """The stage of a simulation."""
    return Stage(simulation.shape.layout, simulation.object, simulation.scene)


def look(simulation: Simulation, phase: str = "") -> Shot:
    """What is to be seen of a simulation now; it stays as it is while that goes on."""
    pose = simulation.object_pose() if simulation.object is not None else ()
    seen = simulation.bodies.q, *simulation.wrist_pose(), *pose
    state = HandState(*(np.array(part) for part in seen))
    pairs = by_pair(simulation.contacts()).values()
    return Shot(
        float(simulation.time),
        state,
        np.array(simulation.pressures()),
        np.array(simulation.air_masses()),
        simulation.air.volumes(simulation.bodies.rotations),
        np.array([total_arrow(contacts) for contacts in pairs]).reshape(-1, 2, 3),
        phase,
    )
