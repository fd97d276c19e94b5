"""Grasps of an object that is held out to the hand, and their response to shaking (8.2.2).

As in the experiment of the thesis: the hand takes its pre-grasp posture, a spring in six directions
holds the object in its place, the hand closes, and the spring is released. Air masses follow their
ramps exactly, as with valves of unlimited flow (our simplification).
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import lru_cache
from weakref import finalize

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from grasp_strategies.in_process_scene import InProcessScene, build_scene
from grasp_strategies.pose import IDENTITY_QUATERNION, Pose
from softhand_model.hand.hand import HandDescription
from thesis.chapter_8.dexterity.feix import FINGERS, PALM, THUMB
from thesis.chapter_8.dexterity.feix_judge import MOST_DRIFT, MOST_TURN, Shaken, Touch
from thesis.chapter_8.dexterity.patterns import Pattern, Times
from thesis.chapter_8.dexterity.posture import FOUR, first_channels, hand_variant
from thesis.chapter_8.dexterity.shaking import motions

Array = NDArray[np.float64]

UNTURNED = "thumb_unturned"  # the thumb's mount at 0 deg
STEP, SEGMENTS = 0.005, 6
AWAY = (0.6, 0.0, 0.1)  # in the wrist frame, where the object waits [m]
LOOKS, BETWEEN = 5, 0.02  # moments of which contacts are averaged, and the time between them [s]
PULL, PULL_TIME = 2.0, 0.2  # net pull in each direction, in weights of the object [-], [s]
MOST_FORCE, FORCE_RATE, MOVED = 20.0, 10.0, 0.010  # [N], [N/s], [m]
DIRECTIONS = np.vstack([np.eye(3), -np.eye(3)])
REST = 0.3  # before the last look [s]
FAR = 0.05  # drift [m] at which a grasp is given up


@dataclass(frozen=True)
class Draw:
    """Variation of a run: shift (3,) [m] and turn (3,) [rad] of the object where it is held, in its
    own axes; factors on its mass, on all friction and on the rubber's modulus.
    """

    shift: tuple[float, ...] = (0.0, 0.0, 0.0)
    turn: tuple[float, ...] = (0.0, 0.0, 0.0)
    mass_scale: float = 1.0
    friction_scale: float = 1.0
    modulus_scale: float = 1.0


def drawn(seed: Sequence[int]) -> Draw:
    """A random variation: place +-1 mm, turn +-2 deg about each axis, mass +-5 %, friction +-15 %,
    modulus +-5 %.

    A seed whose last number is negative gives the opposite of the variation for the positive one.
    """
    sign, rng = math.copysign(1.0, seed[-1]), np.random.default_rng(np.abs(seed).tolist())
    spread = [*[0.001] * 3, *[math.radians(2.0)] * 3, 0.05, 0.15, 0.05]
    found = (sign * rng.uniform(-1.0, 1.0, len(spread)) * spread).tolist()
    scales = [1.0 + part for part in found[6:]]
    return Draw(tuple(found[:3]), tuple(found[3:6]), *scales)


@dataclass(frozen=True)
class Grasped:
    """Observations of a grasp: overlap [m] of object and hand at the start, contacts before and
    after the spring was released, drift [m] and turn [rad] of the object meanwhile, distance [m] of
    each nearby part of the hand afterwards, whether the hand lost the object, and the share of the
    time since the spring began to fade in which the object was within 10 mm of its place.
    """

    overlap: float
    held_out: Sequence[Touch] = ()
    touches: Sequence[Touch] = ()
    drift: float = 0.0
    turn: float = 0.0
    gaps: Mapping[str, float] = field(default_factory=dict)
    dropped: bool = False
    stayed: float = 1.0


def grasping_hand(name: str) -> HandDescription:
    """A variant of the hand, see `posture.hand_variant`, or one whose thumb is not turned."""
    if name != UNTURNED:
        return hand_variant(name)
    hand = hand_variant(FOUR)
    thumb = hand.chain(THUMB)
    straight = replace(thumb, mount=replace(thumb.mount, rpy=(*thumb.mount.rpy[:2], 0.0)))
    return replace(hand, chains=tuple(straight if c.name == THUMB else c for c in hand.chains))


class GraspingHand:
    """A hand upright in the air with an object that can be held out to it.

    Args:
        object: its name.
        variant: of the hand, see `grasping_hand`.
        step: of the physics [s].
        segments: an actuator.
        modulus_scale: factor on the shear modulus of the hand's rubber.
    """

    def __init__(
        self,
        object: str,
        variant: str = FOUR,
        step: float = STEP,
        segments: int = SEGMENTS,
        modulus_scale: float = 1.0,
    ) -> None:
        hand = grasping_hand(variant)
        self.scene: InProcessScene = build_scene(
            hand=hand,
            object=object,
            scene="held",
            step=step,
            segments=segments,
            modulus_scale=modulus_scale,
            finger_contact=True,
        )
        self.simulation = self.scene.simulation
        finalize(self, self.simulation.close)  # the engine has room for a thousand in a process
        self._first = first_channels(hand)
        self._start = self.scene.save()
        self._upright = Pose(*(part.copy() for part in self.simulation.wrist_pose()))
        self._reference = Pose(np.zeros(3), IDENTITY_QUATERNION)

    # ---------------------------------------------------------------- grasp
    def grasp(
        self, pattern: Pattern, times: Times, draw: Draw | None = None, most_overlap: float = np.inf
    ) -> Grasped:
        """Grasp by a pattern. When the object overlaps the pre-grasp posture by more than is
        allowed [m], the grasp ends there. Raises RuntimeError when the simulation diverges.
        """
        draw = draw or Draw()
        self.scene.restart(self._start, (0.0, 0.0), draw.mass_scale, 0.0, draw.friction_scale)
        simulation = self.simulation
        simulation.hold_object(np.array(AWAY), IDENTITY_QUATERNION)
        pre, final = self._masses(pattern.pre), self._masses(pattern.final)
        self._inflate(np.zeros_like(pre), pre, times.pre, np.full(len(pre), True))
        self._run(times.settle)
        turn = Rotation.from_quat(pattern.orientation) * Rotation.from_rotvec(draw.turn)
        place = np.array(pattern.position) + turn.apply(draw.shift)
        simulation.hold_object(place, turn.as_quat())
        overlap = -min(simulation.object_gaps(0.0).values(), default=0.0)
        if overlap > most_overlap:
            return Grasped(overlap)
        self._close(pre, final, times, pattern.palm_first)
        held_out = self.look()
        self._mark()
        simulation.release_object(times.release)
        stayed = self._stayed(times.release + times.settle)
        touches, (drift, turned) = self.look(), self._drift()
        gaps, dropped = simulation.object_gaps(FAR), not touches or drift > FAR
        return Grasped(overlap, held_out, touches, drift, turned, gaps, dropped, stayed)

    def _stayed(self, duration: float) -> float:
        """Simulate a duration [s]; share of it in which the object is near its mark."""
        count, near = round(duration / self.simulation.step_size), 0
        for number in range(1, count + 1):
            self.simulation.step()
            if near == number - 1 and self._drift()[0] <= MOVED:
                near = number
        return near / count

    def pose_only(self, pattern: Pattern, times: Times) -> None:
        """The same motion without the object."""
        self.scene.restart(self._start, (0.0, 0.0), 1.0)
        self.simulation.hold_object(np.array(AWAY), IDENTITY_QUATERNION)
        pre, final = self._masses(pattern.pre), self._masses(pattern.final)
        self._inflate(np.zeros_like(pre), pre, times.pre, np.full(len(pre), True))
        self._run(times.settle)
        self._close(pre, final, times, pattern.palm_first)
        self._run(times.release + times.settle)

    def _close(self, pre: Array, final: Array, times: Times, palm_first: bool) -> None:
        every = np.full(len(pre), True)
        for which in (self._first, ~self._first) if palm_first else (every,):
            self._inflate(pre, final, times.grasp, which)
            pre = np.where(which, final, pre)
        self._run(times.settle)

    def _masses(self, by_channel: Mapping[str, float]) -> Array:
        return np.array([by_channel[name] for name in self.scene.channels])

    def _inflate(self, start: Array, goal: Array, duration: float, which: Array) -> None:
        """Ramp the masses [kg] of some channels linearly from a start to a goal."""
        count = max(1, round(duration / self.simulation.step_size))
        for number in range(1, count + 1):
            masses = np.where(which, start + number / count * (goal - start), start)
            self.simulation.set_air_masses(masses)
            self.simulation.step()

    def _run(self, duration: float) -> None:
        for _ in range(round(duration / self.simulation.step_size)):
            self.simulation.step()

    # ---------------------------------------------------------------- observation
    def object_in_wrist(self) -> Pose:
        """Pose of the object in the wrist frame."""
        wrist = Pose(*self.simulation.wrist_pose())
        position, orientation = self.simulation.object_pose()
        turn = Rotation.from_quat(wrist.orientation).inv() * Rotation.from_quat(orientation)
        return Pose(wrist.locate(position), turn.as_quat())

    def _mark(self) -> None:
        self._reference = self.object_in_wrist()

    def _drift(self) -> tuple[float, float]:
        """Distance [m] and angle [rad] of the object from where it was at the mark."""
        now = self.object_in_wrist()
        turn = Rotation.from_quat(self._reference.orientation).inv()
        turn = turn * Rotation.from_quat(now.orientation)
        return float(np.linalg.norm(now.position - self._reference.position)), turn.magnitude()

    def look(self) -> list[Touch]:
        """Contacts with the object over a tenth of a second, their forces averaged."""
        found = []
        for _ in range(LOOKS):
            self._run(BETWEEN)
            found += self._touches()
        return [replace(touch, force=touch.force / LOOKS) for touch in found]

    def _touches(self) -> list[Touch]:
        position, orientation = self.simulation.wrist_pose()
        to_wrist, skin = Rotation.from_quat(orientation).inv(), self.scene.skin
        found = []
        for contact in self.simulation.object_contacts():
            part, along, side = PALM, 0.0, ""
            if contact.first in skin.chains:
                point = to_wrist.apply(np.array(contact.position) - position)
                place = skin.locate(contact.first, point, self.simulation.bodies.q)
                part, side = contact.first, place.side
                if part in FINGERS:
                    along = float(place.along / place.length)
            normal = to_wrist.apply(contact.normal)
            found.append(Touch(part, along, side, tuple(normal.tolist()), contact.force))
        return found

    def markers(self) -> dict[str, list[float]]:
        """Places [m] in the wrist frame of the markers on the tips: on the backs of the fingers, on
        the thumb at its side (Fig. 8.13).
        """
        skin, q = self.scene.skin, self.simulation.bodies.q
        sides = {THUMB: "+y", **dict.fromkeys(FINGERS, "back")}
        return {name: skin.point(name, 1.0, side, q).tolist() for name, side in sides.items()}

    # ---------------------------------------------------------------- disturbances
    def pull(self) -> tuple[float, float]:
        """Pull the object in six directions with twice its weight, in place of its weight, as the
        search does; greatest drift [m] and turn [rad] meanwhile.
        """
        weight = 9.81 * self.simulation.object_mass
        self._mark()
        drifts = [(0.0, 0.0)]
        for direction in DIRECTIONS:
            force = weight * (PULL * direction + np.array([0.0, 0.0, 1.0]))
            for _ in range(round(PULL_TIME / self.simulation.step_size)):
                self.simulation.push_object(force)
                self.simulation.step()
            drifts.append(self._drift())
            if drifts[-1][0] > FAR:
                break
        return max(way for way, _ in drifts), max(angle for _, angle in drifts)

    def shaken(self, strength: float = 1.0, until_lost: bool = False) -> Shaken:
        """Turn gravity through six directions, shake the wrist along each axis and swing it about
        each; amplitudes of shaking and swinging are scaled by a strength. `until_lost`: end when
        drift or turn exceeds the judge's limit.
        """
        self._mark()
        before, worst = self.look(), np.zeros(2)
        kept: float | None = None
        path, start = motions(self._upright, strength), self.simulation.time
        whole = sum(duration for duration, _ in path)
        for duration, pose in path:
            begin = self.simulation.time
            for number in range(1, round(duration / self.simulation.step_size) + 1):
                target = pose(min(1.0, (self.simulation.time - begin) / duration))
                self.simulation.command_wrist(target.position, target.orientation)
                self.simulation.step()
                if number % 4 == 0:
                    worst = np.maximum(worst, self._drift())
                    if kept is None and (worst > (MOST_DRIFT, MOST_TURN)).any():
                        kept = (self.simulation.time - start) / whole
                    if worst[0] > FAR or (until_lost and kept is not None):
                        drift, turn = map(float, worst)
                        return Shaken(before, [], drift, turn, kept=kept or 0.0)
        self._run(REST)
        after, left = self.look(), self._drift()
        drift, turn = map(float, np.maximum(worst, left))
        return Shaken(before, after, drift, turn, left, 1.0 if kept is None else kept)

    def robust(self) -> float:
        """Least force [N], of six directions in the wrist frame, that moves the object by 10 mm;
        20 N when none does.
        """
        self._mark()
        saved, least = self.scene.save(), MOST_FORCE
        for direction in DIRECTIONS:
            self.simulation.restore(saved)
            force = 0.0
            while force < least and self._drift()[0] < MOVED:
                force += FORCE_RATE * self.simulation.step_size
                self.simulation.push_object(force * direction)
                self.simulation.step()
            least = min(least, force)
        self.simulation.restore(saved)
        return least

    def close(self) -> None:
        """Free the simulation."""
        self.scene.close()


@lru_cache(maxsize=2)
def grasping(
    object: str, variant: str, step: float, segments: int, modulus_scale: float = 1.0
) -> GraspingHand:
    """The hand of given settings; each process keeps the latest two, as a search tries each grasp
    with two moduli.
    """
    return GraspingHand(object, variant, step, segments, modulus_scale)
