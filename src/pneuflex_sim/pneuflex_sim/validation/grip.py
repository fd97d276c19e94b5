"""The tip of a finger held in a pose, in the simulator and in the static chain.

Held is the middle of the last link but one, which is where the last segment begins: the joint in
that segment is left to itself, as the segment is rigid where it is gripped.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import pybullet
from numpy.typing import NDArray
from scipy.optimize import root
from scipy.spatial.transform import Rotation, Slerp

from pneuflex_sim.validation.stand import FingerStand
from softhand_model.chain_front import Front, straight_links
from softhand_model.joint_springs import springs_of
from softhand_model.segments import SegmentChain

Array = NDArray[np.float64]

STRONGEST = 1e4  # [N, N m] of the constraint
MOVING = 60  # steps from one pose to the next
FORCE, MOMENT = 1.0, 0.05  # [N, N m] units of the search


@dataclass(frozen=True)
class Pose:
    """Place (3,) [m] and orientation in the frame of the finger's base."""

    place: Array
    turn: Rotation


class Grip:
    """Holds a simulated finger where it is, and moves it from pose to pose."""

    def __init__(self, stand: FingerStand) -> None:
        self._stand = stand
        layout = stand.simulation.bodies.layout
        self._link = len(layout.mass) - 2
        self._point = np.array([0.0, 0.0, layout.offset[-1, 2] / 2.0])
        self._held = self.pose()
        self._constraint = pybullet.createConstraint(
            stand.simulation.bodies.ids[0],
            self._link,
            -1,
            -1,
            pybullet.JOINT_FIXED,
            [0, 0, 0],
            (self._point - layout.center[self._link]).tolist(),
            (self._held.place + stand.origin).tolist(),
            [0, 0, 0, 1],
            self._held.turn.as_quat().tolist(),
            physicsClientId=stand.client,
        )
        self._command(self._held)

    def pose(self) -> Pose:
        """Where the gripped point is."""
        simulation = self._stand.simulation
        places, turns, _ = simulation.shape.frames(simulation.bodies.q)
        turn = turns[self._link]
        return Pose(places[self._link] + turn @ self._point, Rotation.from_matrix(turn))

    def move(self, pose: Pose, pressure: float) -> None:
        """Go to a pose, the chamber at a pressure [Pa], and wait until the finger is at rest."""
        ends = Rotation.concatenate([self._held.turn, pose.turn])
        turns = Slerp([0.0, 1.0], ends)
        for share in np.linspace(0.0, 1.0, MOVING + 1)[1:]:
            place = self._held.place + share * (pose.place - self._held.place)
            self._command(Pose(place, turns(share)))
            self._stand.step(pressure)
        self._held = pose
        self._stand.rest(pressure)

    def _command(self, pose: Pose) -> None:
        pybullet.changeConstraint(
            self._constraint,
            (pose.place + self._stand.origin).tolist(),
            pose.turn.as_quat().tolist(),
            maxForce=STRONGEST,
            physicsClientId=self._stand.client,
        )


def gripped_part(chain: SegmentChain) -> SegmentChain:
    """The chain from its base to the gripped point, which becomes its tip."""
    rows = {
        name: getattr(chain, name)[:-1]
        for name in ("names", "offset", "rest", "axes", "stiffness", "stretching")
        + ("body_size", "body_center", "mass")
    }
    return replace(chain, **rows, tip_offset=chain.offset[-1] / 2.0)


def pushed(chain: SegmentChain, rest: Array, direction: Array, distance: float) -> Pose:
    """Pose of the tip of a chain whose joints rest at angles (n,) [rad] about y, when a force at
    its tip in a direction (3,) has moved it a distance [m] in that direction.

    Raises RuntimeError where no force does that.

    >>> from pneuflex_sim.validation.static_finger import chain_of
    >>> from softhand_model.actuator import load_actuator
    >>> chain = chain_of(load_actuator("P10.finger"), 4).segments
    >>> pushed(chain, np.zeros(4), np.array([1.0, 0.0, 0.0]), 0.0).place.round(6).tolist()
    [0.0, 0.0, 0.09]
    """
    links, springs = straight_links(chain), springs_of(chain, rest[:, None])

    def tip(force: float, moment: Array) -> Front:
        wrench = np.concatenate([force * direction, moment])
        return Front(wrench[:, None]).follow(links, springs, None)

    start = float(direction @ tip(0.0, np.zeros(3)).place[:, 0])
    length = float(links.along.sum())

    def off(unknown: Array) -> Array:
        force, moment = FORCE * unknown[0], MOMENT * unknown[1:]
        place = tip(force, moment).place[:, 0]
        left = moment - np.cross(place, force * direction)
        return np.append(left / MOMENT, (direction @ place - start - distance) / length)

    found = root(off, np.zeros(4), tol=1e-12).x
    if np.abs(off(found)).max() > 1e-8:
        raise RuntimeError(f"no force moves the tip by {distance} m along {direction}")
    reached = tip(FORCE * found[0], MOMENT * found[1:])
    return Pose(reached.place[:, 0], Rotation.from_matrix(reached.turn[:, :, 0]))
