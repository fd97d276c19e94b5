"""Motion of chains in series under pressures, weight and the motion of the wrist."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from softhand_common.numerics.arrays import Array
from softhand_common.numerics.compiled import compiled
from softhand_model.chain.chain import ChainModel
from softhand_model.chain.segments import link_inertia
from softhand_model.chain.serial import mounted
from softhand_model.dynamics.chain import Links
from softhand_model.dynamics.joint_springs import Springs
from softhand_model.dynamics.rollout import Drive, roll_out
from softhand_model.dynamics.spatial import (
    ZERO,
    apply,
    multiply,
    plus,
    rotation_matrix,
    rows,
    write,
    write_matrix,
)
from softhand_model.effects.load import STANDARD_GRAVITY
from softhand_model.equilibrium.hand_statics import HandBody, Shape
from softhand_model.gas import ROOM_TEMPERATURE
from softhand_model.hand.hand import HandDescription
from softhand_model.motion.wrist_path import INVERSE_QUATERNION, WristPath


class MovingBody(HandBody):
    """Chains in series that move in time. Their dampers are `damping_time` [s] times the stiffness
    of their springs.
    """

    def __init__(
        self,
        description: HandDescription,
        models: Mapping[str, ChainModel],
        damping_time: float,
    ) -> None:
        super().__init__(description, models)
        self._damping_time = damping_time
        cut = {name: chain.segments for name, chain in models.items()}
        size = np.concatenate([part.body_size for part in cut.values()])
        whole, body = np.array([0, len(size)]), self.arrays
        inertia = link_inertia(size, body.mass)
        self._links = Links(
            whole, body.offset, body.center, inertia, body.mass, np.zeros_like(inertia)
        )
        rest = [mounted(description, cut, name)[1] for name in models]
        self._rest = np.ascontiguousarray(np.concatenate(rest))
        mount = description.chain(next(iter(models))).mount
        self._to_base = mount.quaternion * INVERSE_QUATERNION

    def roll(
        self,
        path: WristPath,
        time: Array,
        pressures: Array,
        modulus: float = 1.0,
        temperature: float = ROOM_TEMPERATURE,
        gravity: float = STANDARD_GRAVITY,
    ) -> Shape:
        """The body at times (samples,) [s] under gauge pressures (actuators, samples) [Pa], which
        are linear between samples, on a wrist that follows a path. It is at rest at the first
        sample.

        modulus [-]: factor on the shear modulus of the rubber. temperature [K]. gravity [m/s2].
        Raises NoEquilibriumError as `HandBody.settle` does.
        """
        return self.roll_runs([path], [time], [pressures], modulus, [temperature], gravity)[0]

    def roll_runs(
        self,
        paths: Sequence[WristPath],
        times: Sequence[Array],
        pressures: Sequence[Array],
        modulus: float,
        temperatures: Sequence[float],
        gravity: float,
    ) -> list[Shape]:
        """The shapes of several runs, as `roll` gives them: each run has a path, times [s], gauge
        pressures [Pa] and a temperature [K].
        """
        down = gravity * np.array([path.first_down for path in paths])
        at = [path.at for path in paths]
        starts, bends = self._begin(at, times, pressures, down, modulus, temperatures)
        damping = self._damping_time * self.stiffness(modulus)
        shapes = []
        for run, path in enumerate(paths):
            stiffness = self.stiffness(modulus, np.array([temperatures[run]]))
            springs = Springs(self._rest, stiffness, self.stretching, damping)
            found = np.empty((len(times[run]), *starts.shape[1:]))
            drive = Drive(path.duration, bends[run], *self._base(path, gravity))
            roll_out(self._links, springs, drive, path.kept, starts[run], found)
            shape = Shape(np.empty((*found.shape[:2], 3)), np.empty((*found.shape[:2], 3, 3)))
            arrays = self.arrays
            place_rows(found, arrays.offset, arrays.place, arrays.frame, shape.places, shape.frames)
            shapes.append(shape)
        return shapes

    def _begin(
        self,
        at: Sequence[Array],
        times: Sequence[Array],
        pressures: Sequence[Array],
        down: Array,
        modulus: float,
        temperatures: Sequence[float],
    ) -> tuple[Array, list[Array]]:
        """Orientations (runs, n, 4) of the joints at rest at the first sample of each run, where
        gravity is `down` (runs, 3) [m/s2]; and what pressures add to the joints' rest (steps, n, 3)
        [rad] at the times `at` [s] of its steps.
        """
        warm, first = np.array(temperatures), [course[:, :1] for course in pressures]
        start = self.settle(np.concatenate(first, axis=1), down, modulus, warm)
        acting = [
            np.array([np.interp(steps, time, one) for one in course])
            for steps, time, course in zip(at, times, pressures, strict=True)
        ]
        counts = [len(steps) for steps in at]
        bends = self.free_rotations(
            np.concatenate(acting, axis=1), modulus, np.repeat(warm, counts)
        )
        parts = np.split(np.ascontiguousarray(bends), np.cumsum(counts)[:-1])
        return joint_turns(start.frames, self.arrays.frame), parts

    def _base(self, path: WristPath, gravity: float) -> tuple[Array, Array, Array]:
        """Spin, rate and pull of the body's base, in its own axes (steps, 3)."""
        spin, rate, pull, down = path.of_base(self.arrays.place, self._to_base)
        return spin, rate, pull - gravity * down


def joint_turns(frames: Array, base: Array) -> Array:
    """Orientations (rows, n, 4) of joints relative to the link before, from frames (rows, n, 3, 3)
    of the joints on a base with frame (3, 3).
    """
    from scipy.spatial.transform import Rotation  # here, as it takes long to load

    first = np.broadcast_to(base, (len(frames), 1, 3, 3))
    before = np.concatenate([first, frames[:, :-1]], axis=1)
    turns = before.swapaxes(2, 3) @ frames
    quaternions = Rotation.from_matrix(turns.reshape(-1, 3, 3)).as_quat()
    return np.asarray(quaternions).reshape(*frames.shape[:2], 4)


@compiled
def place_rows(
    q: Array, offset: Array, place: Array, frame: Array, places: Array, frames: Array
) -> None:
    """Fill positions `places` (rows, n, 3) [m] and frames (rows, n, 3, 3) of joints.

    q (rows, n, 4): orientations of the joints. offset (n, 3) [m]: from joint to joint. place (3,)
    [m], frame (3, 3): of the base.
    """
    for row in range(len(q)):
        turned, at = rows(frame), plus(place, ZERO)
        for joint in range(len(offset)):
            at = plus(at, apply(turned, offset[joint]))
            turned = multiply(turned, rotation_matrix(q[row, joint]))
            write(at, places[row, joint])
            write_matrix(turned, frames[row, joint])
