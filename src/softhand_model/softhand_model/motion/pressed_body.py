"""Chains in series that a wrist presses on a plate: force and moment on the wrist."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from softhand_common.numerics.arrays import Array, Indices
from softhand_model.chain.chain import ChainModel
from softhand_model.dynamics.joint_springs import Springs
from softhand_model.dynamics.press import Plate, PressDrive, Skin, press_out
from softhand_model.effects.load import STANDARD_GRAVITY
from softhand_model.equilibrium.hand_statics import frames_of
from softhand_model.gas import ROOM_TEMPERATURE
from softhand_model.hand.hand import HandDescription
from softhand_model.motion.moving_body import MovingBody
from softhand_model.motion.wrist_path import DOWN

SKIN_NORMAL, SKIN_SHEAR = 5000.0, 2000.0  # stiffness of a point of the skin [N/m]
SLOW_WAY, TURNED_LENGTH = 0.03, 0.15  # [m/s] above which steps are shorter, as the way counts; [m]
LEFT_TURN = 1e-3  # [rad] of a joint in the last round of a step, above which a run has no result
FIRST_STEPS, FIRST_STEP = 20, 0.05  # in which a hand that touches at first comes to rest; [s]
CHANGE_TIME = 0.1  # [s] over which a change of the wrist's velocity is taken, as places have noise


@dataclass(frozen=True)
class PressPath:
    """Steps of a press, with the pose of the wrist at the end of each.

    duration (steps,) [s]. place (steps, 3) [m], frame (steps, 3, 3): position and rotation matrix
    of the wrist. acceleration (steps, 3) [m/s2]: of the wrist. at (steps,) [s]: time at the end.
    kept (samples,): number of the step that ends at each sample.
    """

    duration: Array
    place: Array
    frame: Array
    acceleration: Array
    at: Array
    kept: Indices


class Pressed(NamedTuple):
    """A run: force [N] and moment [N m] (samples, 6), and in words which joint does not come to
    rest; "" if all do.
    """

    wrench: Array
    unsettled: str = ""


def press_path(time: Array, place: Array, quaternion: Array, step: float) -> PressPath:
    """The path of a wrist through positions (samples, 3) [m] and orientations (samples, 4),
    quaternions, in the world at times (samples,) [s].

    Between samples it is straight. A step lasts at most `step` [s], less where the wrist is fast.
    Before the first sample the wrist rests for a second. Its acceleration is a second difference
    over CHANGE_TIME, or over half the run if that is shorter. Raises ValueError if time does not
    rise.
    """
    from scipy.spatial.transform import Rotation, Slerp  # here, as it takes long to load

    gaps = np.diff(time)
    if not (gaps > 0.0).all():
        raise ValueError(f"time: expected rising values, got a change of {gaps.min():.3g} s")
    orientations = Rotation.from_quat(quaternion)
    angle = (orientations[:-1].inv() * orientations[1:]).magnitude()
    way = np.linalg.norm(np.diff(place, axis=0), axis=1) + TURNED_LENGTH * angle
    shares = np.maximum(gaps, way / SLOW_WAY) / step
    counts = np.maximum(np.ceil(shares - 1e-9), 1.0).astype(int)
    kept = FIRST_STEPS - 1 + np.concatenate([[0], np.cumsum(counts)])
    duration = np.concatenate([np.full(FIRST_STEPS, FIRST_STEP), np.repeat(gaps / counts, counts)])
    at = np.interp(np.arange(kept[0], kept[-1] + 1), kept, time)
    at = np.concatenate([np.full(FIRST_STEPS - 1, time[0]), at])
    turned = frames_of(Slerp(time, orientations)(at).as_quat())
    apart = min(CHANGE_TIME, 0.5 * (time[-1] - time[0]))
    middle = np.clip(at, time[0] + apart, time[-1] - apart)
    before, here, after = (_along(time, place, middle + late) for late in (-apart, 0.0, apart))
    acceleration = (after - 2.0 * here + before) / apart**2
    acceleration[: FIRST_STEPS - 1] = 0.0
    return PressPath(duration, _along(time, place, at), turned, acceleration, at, kept)


def _along(time: Array, place: Array, at: Array) -> Array:
    """Positions (steps, 3) at times (steps,) on the straight lines between positions (samples, 3)
    at times (samples,).
    """
    return np.stack([np.interp(at, time, course) for course in place.T], axis=1)


def skin_of(description: HandDescription, chains: Iterable[str], segments: int) -> Skin:
    """The skin of chains in series, with `segments` segments per actuator."""
    from softhand_model.chain.hulls import (  # here, as scipy.spatial takes long to load
        COLLISION_MARGIN,
        collision_hulls,
    )

    hulls = [hull for name in chains for hull in collision_hulls(description.chain(name), segments)]
    return Skin(
        np.cumsum([0, *map(len, hulls)]),
        np.ascontiguousarray(np.concatenate(hulls)),
        np.array([np.linalg.norm(hull, axis=1).max() for hull in hulls]),
        COLLISION_MARGIN,
    )


class PressedBody(MovingBody):
    """Chains in series that touch a plate with the hulls of their links."""

    def __init__(
        self,
        description: HandDescription,
        models: Mapping[str, ChainModel],
        damping_time: float,
        skin: Skin | None = None,
    ) -> None:
        super().__init__(description, models, damping_time)
        self._skin = skin or skin_of(description, models, self.segments)

    def press(
        self,
        paths: Sequence[PressPath],
        times: Sequence[Array],
        pressures: Sequence[Array],
        height: float,
        friction: float,
        modulus: float = 1.0,
        temperatures: Sequence[float] | None = None,
        gravity: float = STANDARD_GRAVITY,
    ) -> list[Pressed]:
        """Force [N] and moment [N m] on the wrist (samples, 6) of each run, in the axes of the
        world: of contact with a level plate, of the body's weight less the weight of the body at
        rest, and of its inertia, as if all of it accelerated as the wrist does.

        paths, times (samples,) [s], gauge pressures (actuators, samples) [Pa] and temperatures [K]:
        one for each run. height [m], friction [-]: of the plate. modulus [-]: factor on the shear
        modulus of the rubber. gravity [m/s2].

        A run is NaN if a step of it does not converge: a joint still turns by more than LEFT_TURN
        in the last iteration. Raises NoEquilibriumError as `HandBody.settle`, for the hand in the
        air.
        """
        warm = temperatures or [ROOM_TEMPERATURE] * len(paths)
        at, down = [path.at for path in paths], [DOWN @ path.frame[0] for path in paths]
        starts, bends = self._begin(at, times, pressures, gravity * np.array(down), modulus, warm)
        damping = self._damping_time * self.stiffness(modulus)
        plate = Plate(height, friction, SKIN_NORMAL, SKIN_SHEAR)
        weight = gravity * self._links.mass.sum()
        pressed = []
        for path, start, bend, temperature in zip(paths, starts, bends, warm, strict=True):
            stiffness = self.stiffness(modulus, np.array([temperature]))
            drive = PressDrive(
                path.duration,
                bend,
                path.place + path.frame @ self.arrays.place,
                path.frame @ self.arrays.frame,
                path.place,
                gravity * DOWN - path.acceleration,
            )
            springs = Springs(self._rest, stiffness, self.stretching, damping)
            found = np.empty((len(path.kept), 6))
            left, step, joint = press_out(
                self._links, springs, self._skin, plate, drive, path.kept, start, found
            )
            if left > LEFT_TURN:
                still = f"{self._name_of(joint)} does not come to rest at {path.at[step]:.3g} s"
                pressed.append(Pressed(np.full_like(found, np.nan), still))
                continue
            found[:, 2] += weight
            lever = path.frame[path.kept] @ self._resting_center
            found[:, 3:] -= np.cross(lever, weight * DOWN)
            pressed.append(Pressed(found))
        return pressed

    def _name_of(self, joint: int) -> str:
        """A joint in words, counted from the base of its chain."""
        for name, part in self.joints.items():
            if joint < part.stop:
                return f"joint {joint - part.start + 1} of {name}"
        raise IndexError(f"joint: expected one of the body, got {joint}")

    @cached_property
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
