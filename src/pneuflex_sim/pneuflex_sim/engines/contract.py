"""The interface of an engine to `pneuflex_sim.simulation.Simulation`.

An engine moves the bodies: chains of links with springs that follow the pressures, the wrist under
the arm's law (`pneuflex_sim.hand.wrist`), the object, and their contacts with the scene. Air,
valves, sensors, strategies and judges are the same code for all engines.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Protocol

from pneuflex_sim.hand.air import AirCoupling
from pneuflex_sim.hand.layout import HandLayout
from pneuflex_sim.hand.wrist import Wrist
from pneuflex_sim.scene.contacts import Contact
from pneuflex_sim.scene.friction import FrictionTable
from pneuflex_sim.scene.object_protocol import BodyOfObject
from pneuflex_sim.scene.objects import ObjectDescription
from pneuflex_sim.scene.scenes import SceneDescription
from pneuflex_sim.world import SolverSettings
from softhand_common.numerics.arrays import Array


@dataclass(frozen=True)
class Surroundings:
    """The parts from which an engine is built.

    step [s]: time step of the physics. layout, air, wrist: the hand, its air, and what carries it.
    scene, friction, object: the surroundings; None without an object. weight_scale [-]: share of
    gravity that acts on the hand; it acts on the object in full. The other fields are those of
    `SimulationConfig`.
    """

    step: float
    layout: HandLayout
    air: AirCoupling
    scene: SceneDescription
    friction: FrictionTable
    object: ObjectDescription | None
    wrist: Wrist
    weight_scale: float
    collision: str
    finger_contact: bool
    gui: bool
    solver: SolverSettings


class Hand(Protocol):
    """Joints of a hand: `q` (n, 4) orientations, `v` (n, 3) [rad/s] speeds in the axes of each
    child, `rotations` (n, 3) [rad] against the rest without pressure.
    """

    layout: HandLayout
    q: Array
    v: Array
    rotations: Array

    def reset(self, wrist: Wrist, joints: Array | None = None) -> None:
        """Place the hand at the wrist, with joint orientations `joints` (n, 4), by default those at
        rest without pressure."""


class Engine(Protocol):
    """A simulated world: hand on its wrist, object and scene."""

    @property
    def broken(self) -> bool:
        """Whether the simulation has diverged, so that the engine must be built anew."""

    @property
    def bodies(self) -> Hand:
        """The joints of the hand."""

    @property
    def object(self) -> BodyOfObject | None:
        """The object, if the scene has one."""

    def drive(self, ambient: float, pressures_abs: Array, volumes: Array, wrist: Wrist) -> None:
        """Apply the springs of the joints at absolute pressures [Pa] and volumes [m3] of the
        channels, and the arm's push on the wrist.
        """

    def advance(self, wrist: Wrist) -> None:
        """Simulate one step, after which joints and `wrist` have their state at its end; raises
        Diverged when the simulation has diverged.
        """

    def contacts(self) -> list[Contact]:
        """All contact points that carry a force."""

    def object_contacts(self) -> list[Contact]:
        """Contact points of the object with anything."""

    def touching_object(self) -> frozenset[str]:
        """Names of the bodies that press on the object."""

    def object_gaps(self, reach: float) -> dict[str, float]:
        """Distance [m] of the object from each part of the hand within a reach [m]."""

    def object_boxes(self) -> Array:
        """Boxes (k, 2, 3) [m] around the parts of the object, along the world's axes: lowest and
        highest corner of each.
        """

    def hand_boxes(self) -> Array:
        """Boxes (k, 2, 3) [m], as `object_boxes`, around the hand's links, palm sheet and plate."""

    def scale_friction(self, factor: float) -> None:
        """Set sliding and twisting friction of every pair of bodies to `factor` [-] times that of
        the table of friction.
        """

    def save(self) -> Any:
        """The engine's state, for `restore`."""

    def restore(self, saved: Any) -> None:
        """Return to a state of `save`, bit for bit."""

    def close(self) -> None:
        """Free what the engine holds."""
