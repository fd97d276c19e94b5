"""Statics of a whole hand without contact: equilibrium of its chains under pressures and weight.

Chains in series (the thumb on the palm) are one body. A joint carries the weight of all links
beyond it, and turns as its spring yields, which moves that weight. Joints are placed from the
wrist, and moments are summed from the tip, again and again until nothing moves.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from softhand_common.numerics.arrays import Array
from softhand_common.numerics.compiled import compiled, without_allocation
from softhand_common.numerics.rotations import matrices
from softhand_common.numerics.triples import (
    Matrix,
    Vector,
    apply,
    cross,
    minus,
    multiply,
    plus,
    rotation,
    scaled,
    transposed,
)
from softhand_model.chain.chain import ChainModel, discretise
from softhand_model.chain.free_response import NoEquilibriumError
from softhand_model.chain.segments import BEND_AXIS
from softhand_model.chain.serial import mounted, serial_chains
from softhand_model.effects.hand import altered, pressure_offsets, pressure_shares
from softhand_model.equilibrium.joint_balance import TABLE_NODES, SpringArrays, joint_rotation
from softhand_model.equilibrium.joint_springs import off_rest, plain
from softhand_model.gas import ROOM_TEMPERATURE
from softhand_model.hand.hand import HandDescription
from softhand_model.model_file import Model

MOST_PASSES = 500
LEAST_MOTION = 1e-9  # [rad] by which no joint moves any more


class BodyArrays(NamedTuple):
    """A body with n joints.

    place (3,) [m], frame (3, 3): of its base in the wrist frame. offset (n, 3) [m], rest (n, 3, 3),
    mass (n,) [kg], center (n, 3) [m]: of joints and links, as in `SegmentChain`.
    """

    place: Array
    frame: Array
    offset: Array
    rest: Array
    mass: Array
    center: Array


@dataclass(frozen=True)
class Shape:
    """A body at rest: positions `places` (rows, n, 3) [m] and frames (rows, n, 3, 3) of its joints
    in the wrist frame.
    """

    places: Array
    frames: Array


class HandBody:
    """One finger of a hand, or the palm with a thumb on its tip: chains of which each is mounted on
    the tip of the one before, or on the wrist.

    models: the chains by name, from the wrist outwards. actuators: names of their actuators, in the
    order in which pressures are given. joints: for each chain, the slice of its joints among those
    of the body. arrays: geometry and masses of all links. stretching (n,): for each joint, the
    `stretching` of its `SegmentChain`.
    """

    def __init__(self, description: HandDescription, models: Mapping[str, ChainModel]) -> None:
        self._models, chains = models, tuple(models)
        self.actuators = tuple(
            name for chain in self._models.values() for name in chain.description.actuators
        )
        self.segments = next(iter(models.values())).count
        cut = {name: chain.segments for name, chain in self._models.items()}
        placed = [mounted(description, cut, name) for name in chains]
        self.joints: dict[str, slice] = {}
        for name, (offset, _) in zip(chains, placed, strict=True):
            first = max((part.stop for part in self.joints.values()), default=0)
            self.joints[name] = slice(first, first + len(offset))
        rest = np.concatenate([orientation for _, orientation in placed])
        mount = description.chain(chains[0]).mount
        self.arrays = BodyArrays(
            np.array(mount.position, float),
            frames_of(mount.quaternion[None])[0],
            np.concatenate([offset for offset, _ in placed]),
            frames_of(rest),
            np.concatenate([part.mass for part in cut.values()]),
            np.concatenate([part.body_center for part in cut.values()]),
        )
        self._stiffness = np.concatenate([part.stiffness for part in cut.values()])
        self._struts = np.zeros(len(rest), bool)
        for name in chains:
            if description.chain(name).strut is not None:
                self._struts[self.joints[name].start] = True
        self.stretching = np.concatenate([part.stretching for part in cut.values()])

    def settle(
        self,
        pressures: Array,
        gravity: Array,
        modulus: float = 1.0,
        temperature: Array | float = ROOM_TEMPERATURE,
    ) -> Shape:
        """The body at rest under gauge pressures (actuators, rows) [Pa] and gravity (rows, 3)
        [m/s2] in the wrist frame.

        modulus [-]: factor on the shear modulus of the rubber. temperature [K]: a number or
        (rows,). Raises NoEquilibriumError if the springs cannot carry the weight, or effects leave
        no equilibrium of the rubber.
        """
        warm = np.broadcast_to(np.asarray(temperature, float), pressures.shape[1])
        bend = self.free_rotations(pressures, modulus, warm)
        rows, joints = bend.shape[:2]
        shape = Shape(np.empty((rows, joints, 3)), np.empty((rows, joints, 3, 3)))
        moved = settle(
            self.arrays,
            self._springs(bend[:, :, BEND_AXIS], modulus, warm),
            np.ascontiguousarray(bend),
            np.ascontiguousarray(gravity, float),
            shape.places,
            shape.frames,
        )
        if not moved < LEAST_MOTION:
            raise NoEquilibriumError(
                f"chains {' + '.join(self._models)}: no equilibrium under their weight: joints "
                f"still move by {moved:.3g} rad after {MOST_PASSES} passes"
            )
        return shape

    def free_rotations(self, pressures: Array, modulus: float, temperature: Array) -> Array:
        """Rotations (rows, n, 3) [rad] of the joints without load, at gauge pressures (actuators,
        rows) [Pa] and temperatures (rows,) [K]; modulus [-]: factor on the shear modulus of the
        rubber.
        """
        bends, first = [], 0
        for chain in self._models.values():
            last = first + len(chain.description.actuators)
            bends.append(chain.rest_rotations(pressures[first:last], modulus, temperature))
            first = last
        return np.concatenate(bends, axis=1)

    def stiffness(self, modulus: float, temperature: Array | None = None) -> Array:
        """Stiffness (n, 3) [N m/rad] of the joints.

        modulus [-]: factor on the shear modulus of the rubber, not of struts. temperature (1,) [K];
        None: effects of temperature are left out.
        """
        factor = np.where(self._struts, 1.0, modulus)
        if temperature is not None:
            warm = [chain.modulus_factors(temperature)[0] for chain in self._models.values()]
            factor = factor * np.concatenate(warm)
        return self._stiffness * factor[:, None]

    def joint_at(self, chain: str, at: float) -> int:
        """Number of the joint in the segment of a straight chain at a share of its length."""
        index = min(int(at * self.segments), self.segments - 1)
        return self.joints[chain].stop - self.segments + index

    def point(self, shape: Shape, chain: str, at: float, offset: Array) -> Array:
        """Positions (rows, 3) [m], in the wrist frame, of a point on a straight chain.

        offset (3,) [m]: from the centre line at `at`, in the frame of that line. For shape, at and
        errors see `placed`.
        """
        place, frame = self.placed(shape, chain, at)
        return np.asarray(place + frame @ np.asarray(offset, float))

    def placed(self, shape: Shape, chain: str, at: float) -> tuple[Array, Array]:
        """Positions (rows, 3) [m] and frames (rows, 3, 3), in the wrist frame, of the centre line
        of a straight chain.

        at [-]: place along the rubber, as a share of its length. shape: of all joints, or of the
        last ones of the body. Raises ValueError for a chain of arcs.
        """
        description = self._models[chain].description
        if description.turn:
            raise ValueError(f"marker: expected one on a straight chain, got the arcs of {chain}")
        edge = next(iter(description.actuators.values())).length / self.segments
        last = self.joints[chain].stop
        joint = self.joint_at(chain, at)
        share = at * self.segments - (joint - last + self.segments)
        left = joint - len(self.arrays.mass)  # counted from the last one
        after = shape.frames[:, left]
        if joint > 0:
            before = shape.frames[:, left - 1] @ self.arrays.rest[joint]
        else:
            before = np.broadcast_to(self.arrays.frame @ self.arrays.rest[joint], after.shape)
        along = np.stack([before[:, :, 2], after[:, :, 2]]) * edge
        ends = shape.places[:, left] + np.stack([-along[0], along[1]]) / 2.0
        frame = after if share == 1.0 else _between(before, after, share)
        return _hermite(share, ends, along), frame

    def _springs(self, rest_bend: Array, modulus: float, temperature: Array) -> SpringArrays:
        """The springs at every row, for rest bends (rows, n) [rad]; struts are as stiff as ever."""
        rows, bending = len(rest_bend), self._stiffness[:, BEND_AXIS]
        scaled_bending = self.stiffness(modulus)[:, BEND_AXIS]
        warm = [chain.modulus_factors(temperature) for chain in self._models.values()]
        rest = plain(rest_bend.T)
        return SpringArrays(
            False,
            plain(scaled_bending[:, None] * np.concatenate(warm, axis=1).T),
            rest,
            np.sin(rest),
            np.cos(rest),
            plain(self._stiffness[:, [0, 2]] / bending[:, None]),
            plain(self.stretching),
            np.zeros(rows),
            self._bend_factors(rest_bend),
        )

    def _bend_factors(self, rest_bend: Array) -> Array:
        """Factors (rows, n, 2, TABLE_NODES) [-] in bending, with no rows where there are none."""
        found = [
            chain.bend_factors(rest_bend[:, self.joints[name]], off_rest())
            for name, chain in self._models.items()
        ]
        known = [factors for factors in found if factors is not None]
        if not known:
            return np.empty((0, rest_bend.shape[1], 2, TABLE_NODES))
        return plain(np.concatenate(known, axis=1))


def settled_hand(
    hand: HandDescription, model: Model, segments: int, pressures: Array, gravity: Array
) -> list[tuple[HandBody, Shape]]:
    """(body, its shape at rest) for all bodies of a hand under a model, at room temperature.
    segments: number per actuator.

    pressures (channels, rows) [Pa]: gauge pressures. gravity (rows, 3) [m/s2]: in the wrist frame.
    Raises ValueError as `discretise` does and for an effect at a place that the hand does not have,
    and NoEquilibriumError as `HandBody.settle` does.
    """
    askew = altered(hand, model.effects)
    felt = pressures - pressure_offsets(hand, model.effects)[:, None]
    shares = pressure_shares(hand, model.effects)
    acting = dict(zip(hand.actuator_names, shares @ felt, strict=True))
    found = []
    for chains in serial_chains(hand):
        models = {name: discretise(askew.chain(name), segments, model) for name in chains}
        body = HandBody(askew, models)
        own = np.array([acting[name] for name in body.actuators])
        found.append((body, body.settle(own, gravity)))
    return found


def frames_of(quaternions: Array) -> Array:
    """Rotation matrices (n, 3, 3) of quaternions (n, 4)."""
    return np.ascontiguousarray(np.moveaxis(matrices(np.asarray(quaternions).T), -1, 0))


def _hermite(share: float, ends: Array, along: Array) -> Array:
    """Places (rows, 3) at a share of the cubics with these ends and slopes (2, rows, 3)."""
    s, left = share, 1.0 - share
    return np.asarray(
        left * left * (1.0 + 2.0 * s) * ends[0]
        + s * s * (3.0 - 2.0 * s) * ends[1]
        + s * left * left * along[0]
        - s * s * left * along[1]
    )


def _between(before: Array, after: Array, share: float) -> Array:
    """Frames (rows, 3, 3) at a share of the turn from one to the other."""
    from scipy.spatial.transform import Rotation  # here, as it takes long to load

    turn = Rotation.from_matrix(np.swapaxes(before, -1, -2) @ after).as_rotvec()
    return np.asarray(before @ Rotation.from_rotvec(share * turn).as_matrix())


# ---------------------------------------------------------------------- compiled
@without_allocation
def _vector(array: Array) -> Vector:
    return (array[0], array[1], array[2])


@without_allocation
def _matrix(array: Array) -> Matrix:
    return (_vector(array[0]), _vector(array[1]), _vector(array[2]))


@compiled
def settle(
    body: BodyArrays,
    springs: SpringArrays,
    bend: Array,
    gravity: Array,
    places: Array,
    frames: Array,
) -> float:
    """Fill places (rows, n, 3) [m] and frames (rows, n, 3, 3) of the joints at rest, and return the
    largest rotation [rad] of a joint in the last pass.

    bend (rows, n, 3) [rad]: rotations of the joints without load. gravity (rows, 3) [m/s2].
    """
    joints, worst = len(body.mass), 0.0
    turns, free = np.zeros((joints, 3)), np.zeros((joints, 3, 3))
    resting = np.zeros((joints, 3, 3))
    for row in range(len(bend)):
        turns[:] = 0.0
        moved = 1.0
        for joint in range(joints):
            turn = rotation(_vector(bend[row, joint]))
            _fill(free[joint], multiply(_matrix(body.rest[joint]), turn))
        for _ in range(MOST_PASSES):
            _place(body, free, turns, resting, places[row], frames[row])
            moved = _yield(
                body, springs, row, gravity[row], resting, places[row], frames[row], turns
            )
            if moved < LEAST_MOTION:
                break
        worst = max(worst, moved)
    return worst


@without_allocation
def _fill(array: Array, matrix: Matrix) -> None:
    for row in range(3):
        for column in range(3):
            array[row, column] = matrix[row][column]


@without_allocation
def _place(
    body: BodyArrays, free: Array, turns: Array, resting: Array, places: Array, frames: Array
) -> None:
    """Place the joints at rotations `turns` (n, 3) [rad] from their rest frames (n, 3, 3), which
    are filled, too; free (n, 3, 3): the rest frame of each in that of the joint before it.
    """
    place, frame = _vector(body.place), _matrix(body.frame)
    for joint in range(len(body.mass)):
        place = plus(place, apply(frame, _vector(body.offset[joint])))
        rest = multiply(frame, _matrix(free[joint]))
        frame = multiply(rest, rotation(_vector(turns[joint])))
        for row in range(3):
            places[joint, row] = place[row]
        _fill(resting[joint], rest)
        _fill(frames[joint], frame)


@without_allocation
def _yield(
    body: BodyArrays,
    springs: SpringArrays,
    row: int,
    gravity: Array,
    resting: Array,
    places: Array,
    frames: Array,
    turns: Array,
) -> float:
    """Turn every joint as the weight beyond it wants, from tip to base; the largest change [rad] of
    a rotation.
    """
    force, moment, moved = (0.0, 0.0, 0.0), (0.0, 0.0, 0.0), 0.0
    beyond = _vector(places[-1])
    for joint in range(len(body.mass) - 1, -1, -1):
        place, weight = _vector(places[joint]), scaled(body.mass[joint], _vector(gravity))
        arm = apply(_matrix(frames[joint]), _vector(body.center[joint]))
        moment = plus(moment, cross(minus(beyond, place), force))
        moment = plus(moment, cross(arm, weight))
        force, beyond = plus(force, weight), place
        local = apply(transposed(_matrix(resting[joint])), moment)
        turn = _turn(springs, joint, row, local)
        for axis in range(3):
            moved = max(moved, abs(turn[axis] - turns[joint, axis]))
            turns[joint, axis] = turn[axis]
    return moved


@without_allocation
def _turn(springs: SpringArrays, joint: int, row: int, moment: Vector) -> Vector:
    """`joint_rotation`, in closed form where a spring is linear and the same about all axes."""
    alike = springs.sideways[joint, 0] == 1.0 and springs.sideways[joint, 1] == 1.0
    if alike and springs.stretching[joint] == 0.0 and len(springs.factor) == 0:
        return scaled(1.0 / springs.stiffness[joint, row], moment)
    return joint_rotation(springs, joint, row, moment)
