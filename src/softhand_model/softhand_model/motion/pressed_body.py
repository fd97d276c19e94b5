"""Chains in series that a wrist presses on a plate: force and moment on the wrist."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from softhand_common.numerics.arrays import Array, Indices
from softhand_common.numerics.rotations import rotate
from softhand_model.chain.chain import ChainModel
from softhand_model.chain.free_response import NoEquilibriumError
from softhand_model.dynamics.joint_springs import Springs
from softhand_model.dynamics.press import Plate, PressDrive, Skin, press_out
from softhand_model.effects.load import STANDARD_GRAVITY
from softhand_model.equilibrium.hand_statics import frames_of
from softhand_model.gas import ROOM_TEMPERATURE
from softhand_model.hand.hand import HandDescription
from softhand_model.motion.moving_body import MovingBody, joint_turns
from softhand_model.motion.wrist_path import DOWN, INVERSE_QUATERNION

SKIN_NORMAL, SKIN_SHEAR = 5000.0, 2000.0  # stiffness of a point of the skin [N/m]
SLOW_WAY, TURNED_LENGTH = 0.015, 0.15  # [m/s] above which steps are shorter, as the way counts; [m]
LEFT_TURN = 1e-3  # [rad] of a joint in the last round of a step, above which it has no result
FIRST_STEPS, FIRST_STEP = 20, 0.05  # in which a hand that touches at first comes to rest; [s]


@dataclass(frozen=True)
class PressPath:
    """Steps of a press, and where the wrist is at the end of each: duration (steps,) [s], place
    (steps, 3) [m], orientation (steps, 4); at (steps,) [s], the times. kept (samples,): number of
    the step at whose end each sample is.
    """

    duration: Array
    place: Array
    orientation: Array
    at: Array
    kept: Indices


def press_path(time: Array, place: Array, quaternion: Array, step: float) -> PressPath:
    """The path through places (samples, 3) [m] and orientations (samples, 4) of a wrist in the
    world at times (samples,) [s], straight between them, in steps of at most `step` [s], and of
    less where it is fast; at first it rests for a second.
    """
    from scipy.spatial.transform import Rotation, Slerp  # here, as it takes long to load

    gaps = np.diff(time)
    if not (gaps > 0.0).all():
        raise ValueError(f"time: expected to rise, got a gap of {gaps.min():.3g} s")
    orientations = Rotation.from_quat(quaternion)
    angle = (orientations[:-1].inv() * orientations[1:]).magnitude()
    way = np.linalg.norm(np.diff(place, axis=0), axis=1) + TURNED_LENGTH * angle
    shares = np.maximum(gaps, way / SLOW_WAY) / step
    counts = np.maximum(np.ceil(shares - 1e-9), 1.0).astype(int)
    kept = FIRST_STEPS - 1 + np.concatenate([[0], np.cumsum(counts)])
    duration = np.concatenate([np.full(FIRST_STEPS, FIRST_STEP), np.repeat(gaps / counts, counts)])
    at = np.interp(np.arange(kept[0], kept[-1] + 1), kept, time)
    at = np.concatenate([np.full(FIRST_STEPS - 1, time[0]), at])
    along = np.stack([np.interp(at, time, course) for course in place.T], axis=1)
    turned = Slerp(time, orientations)(at).as_quat()
    return PressPath(duration, along, turned, at, kept)


class PressedBody(MovingBody):
    """Chains in series that touch a plate with the hulls of their links."""

    def __init__(
        self,
        description: HandDescription,
        models: Mapping[str, ChainModel],
        damping_time: float,
    ) -> None:
        from softhand_model.chain.hulls import (  # here, as scipy.spatial takes long to load
            COLLISION_MARGIN,
            collision_hulls,
        )

        super().__init__(description, models, damping_time)
        hulls = [
            hull
            for name in models
            for hull in collision_hulls(description.chain(name), self.segments)
        ]
        counts = [len(hull) for hull in hulls]
        reach = [np.linalg.norm(hull, axis=1).max() for hull in hulls]
        self._skin = Skin(
            np.concatenate([[0], np.cumsum(counts)]),
            np.ascontiguousarray(np.concatenate(hulls)),
            np.array(reach),
            COLLISION_MARGIN,
        )

    def press(
        self,
        path: PressPath,
        time: Array,
        pressures: Array,
        height: float,
        friction: float,
        modulus: float = 1.0,
        temperature: float = ROOM_TEMPERATURE,
        gravity: float = STANDARD_GRAVITY,
    ) -> Array:
        """Force [N] and moment [N m] on the wrist (samples, 6), in the axes of the world, of
        contact with a level plate at a height [m], and of the weight [m/s2] less that of the
        resting body; at times (samples,) [s], gauge pressures (actuators, samples) [Pa], of a
        temperature [K] and a rubber whose modulus is `modulus` [-] times as large.

        Raises NoEquilibriumError as `HandBody.settle`, for the hand in the air, and for a step in
        which joints still turn by more than LEFT_TURN when the rounds are used up.
        """
        warm = np.array([temperature])
        down = gravity * rotate(path.orientation[0] * INVERSE_QUATERNION, DOWN)
        start = self.settle(pressures[:, :1], down[None], modulus, warm)
        q = joint_turns(start.frames, self.arrays.frame)[0]
        acting = np.array([np.interp(path.at, time, one) for one in pressures])
        bend = self.free_rotations(acting, modulus, np.full(len(path.at), temperature))
        turned = frames_of(path.orientation)
        drive = PressDrive(
            path.duration,
            np.ascontiguousarray(bend),
            path.place + turned @ self.arrays.place,
            np.ascontiguousarray(turned @ self.arrays.frame),
            path.place,
            gravity,
        )
        stiffness = self.stiffness(modulus, warm)
        damping = self._damping_time * self.stiffness(modulus)
        springs = Springs(self._rest, stiffness, self.stretching, damping)
        plate = Plate(height, friction, SKIN_NORMAL, SKIN_SHEAR)
        found = np.empty((len(path.kept), 6))
        left = press_out(self._links, springs, self._skin, plate, drive, path.kept, q, found)
        if left > LEFT_TURN:
            raise NoEquilibriumError(f"a joint turns by {left:.2g} rad in the last round of a step")
        weight = gravity * self._links.mass.sum()
        lever = turned[path.kept] @ self._resting_center()
        found[:, 2] += weight
        found[:, 3:] -= np.cross(lever, weight * DOWN)
        return found

    def _resting_center(self) -> Array:
        """Centre of mass (3,) [m] of the body at rest without pressure, in the wrist frame."""
        arrays, place, frame, total = self.arrays, self.arrays.place, self.arrays.frame, 0.0
        for offset, rest, mass, center in zip(
            arrays.offset, arrays.rest, arrays.mass, arrays.center, strict=True
        ):
            place = place + frame @ offset
            frame = frame @ rest
            total = total + mass * (place + frame @ center)
        return np.asarray(total / arrays.mass.sum())
