"""Motion of the wrist of a hand, and the time steps in which it is followed."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from softhand_common.numerics.arrays import Array, Indices
from softhand_common.numerics.rotations import rotate
from softhand_model.dynamics.rollout import THETA

DOWN = np.array([0.0, 0.0, -1.0])  # of the world
INVERSE_QUATERNION = np.array([-1.0, -1.0, -1.0, 1.0])
KEPT_BASES = 32  # of bodies on a wrist


@dataclass(frozen=True)
class WristPath:
    """The steps of a run, and the motion of the wrist at the share THETA of each step, in its own
    axes.

    kept (samples,): number of steps before each sample. duration (steps,) [s]. at (steps,) [s]:
    times at which the motion is taken. spin (steps, 3) [rad/s], rate (steps, 3) [rad/s2],
    acceleration (steps, 3) [m/s2]: of the wrist. down (steps, 3): direction of the weight.
    first_down (3,): the same at the first sample.
    """

    kept: Indices
    duration: Array
    at: Array
    spin: Array
    rate: Array
    acceleration: Array
    down: Array
    first_down: Array
    _bases: dict[bytes, tuple[Array, ...]] = field(default_factory=dict, repr=False, compare=False)

    def of_base(self, place: Array, to_base: Array) -> tuple[Array, ...]:
        """Spin, rate, acceleration and direction of the weight (steps, 3) as above, of a base at
        `place` (3,) [m] on the wrist, in its own axes, into which the quaternion `to_base` turns.
        The latest ones are kept, as many bodies have the same base.
        """
        key = np.concatenate([place, to_base]).tobytes()
        if key not in self._bases:
            if len(self._bases) >= KEPT_BASES:
                del self._bases[next(iter(self._bases))]
            about = np.cross(self.rate, place)
            about += np.cross(self.spin, np.cross(self.spin, place))
            moved = (self.spin, self.rate, self.acceleration + about, self.down)
            self._bases[key] = tuple(np.ascontiguousarray(rotate(to_base, part)) for part in moved)
        return self._bases[key]


def held_wrist(time: Array, quaternion: Array, step: float) -> WristPath:
    """The path of a wrist that is held at an orientation (4,), a quaternion x, y, z, w, in the
    world, z up.

    time (samples,) [s]: of the samples. step [s]: longest time step.
    """
    kept, duration, at = steps_between(time, step)
    down = rotate(quaternion * INVERSE_QUATERNION, DOWN)
    still = np.zeros((len(at), 3))
    return WristPath(kept, duration, at, still, still, still, still + down, down)


def moved_wrist(time: Array, place: Array, quaternion: Array, step: float) -> WristPath:
    """The path of a wrist with positions (samples, 3) [m] and orientations (samples, 4) in the
    world, z up.

    They are interpolated by cubic splines, so they must be free of jumps and noise. time, step: as
    for `held_wrist`.
    """
    from scipy.interpolate import CubicSpline  # here, as it takes long to load
    from scipy.spatial.transform import Rotation, RotationSpline

    kept, duration, at = steps_between(time, step)
    turning = RotationSpline(time, Rotation.from_quat(quaternion))
    to_wrist = turning(at).inv()
    return WristPath(
        kept,
        duration,
        at,
        turning(at, 1),
        turning(at, 2),
        to_wrist.apply(CubicSpline(time, place)(at, 2)),
        to_wrist.apply(DOWN),
        turning(time[:1]).inv().apply(DOWN)[0],
    )


def steps_between(time: Array, step: float) -> tuple[Indices, Array, Array]:
    """Divide the time between samples into steps: (number of steps before each of the rising times
    (samples,) [s], durations (steps,) [s] of at most `step` [s], times (steps,) [s] at the share
    THETA of each step).
    """
    gaps = np.diff(time)
    if not (gaps > 0.0).all():
        raise ValueError(f"time: expected rising values, got a change of {gaps.min():.3g} s")
    counts = np.maximum(np.ceil(gaps / step - 1e-9), 1.0).astype(int)
    kept = np.concatenate([[0], np.cumsum(counts)])
    duration = np.repeat(gaps / counts, counts)
    place = np.arange(len(duration)) - np.repeat(kept[:-1], counts)
    return kept, duration, np.repeat(time[:-1], counts) + (place + THETA) * duration
