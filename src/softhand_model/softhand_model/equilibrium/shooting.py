"""Shooting solver, compiled: base wrench for a prescribed tip pose, point after point.

Each point has six unknowns and six equations, whatever the number of joints. Wrenches are in units
of `HeldPoints.unit`, poses in lengths of the chain and radians.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from softhand_common.numerics.arrays import Array, Flags
from softhand_common.numerics.compiled import compiled
from softhand_common.numerics.triples import (
    Matrix,
    Vector,
    cross,
    dot,
    matrix_at,
    minus,
    multiply,
    plus,
    rotation_vector,
    scaled,
    transposed,
    vector_at,
)
from softhand_model.equilibrium.chain_march import CHANGES, POSITION_CHANGE, SPIN, Links, march
from softhand_model.equilibrium.joint_balance import SpringArrays

CLAMP = 1e-7  # compliance of the tip's clamp over that of the chain as a cantilever
STRONG_FORCE = 40.0  # [B/L**2] at which the clamp has yielded by YIELD
YIELD = 0.01  # [lengths of the chain], with the cube of the force
LARGEST_FORCE = (
    60.0  # [B/L**2]; larger ones belong to equilibria that pull the tip out of its clamp
)
POSE_TOLERANCE = 1e-11  # of the tip's pose, in lengths of the chain and radians
REACHED_POSE = 1e-9  # likewise, for a pose at which rounding ends the iteration
SHOOTING_STEPS = 80
LARGEST_WRENCH_STEP = 3.0  # of the wrench, in units of B/L**2 and B/L
SHORTEST_SHARE = 1e-3  # of a Newton step
LEAST_MENDED = 0.1  # share of its length that a chord keeps along the last step
POSE_ROUNDING = 1e-15  # of the tip's pose
CHORDS = 8  # steps with a slope of another point before it is discarded
CHORD_PROGRESS = 0.3  # factor by which each step must reduce the distance of the tip
SOFTER = (1e6, 1e5, 1e4, 1e3, 1e2, 1e1, 1.0)  # clamps in turn, for poses that are hard to find
LARGEST_CURL = 4.0 * np.pi  # [rad] of the free chain
AMBIGUOUS = 0.6  # [rad] by which a rotation must differ from half a turn to have a clear direction


class HeldPoints(NamedTuple):
    """A chain with both ends held, at n points.

    position (3, n) [m], orientation (3, 3, n): of the tip. gravity (3, n or 0) [m/s2]. softest (n,)
    [rad/(N m)]: by how much a moment turns the tip about the axes about which the joints are
    softest. length [m]: of the chain. unit (6,) [N, N m]: units of wrenches.
    """

    links: Links
    springs: SpringArrays
    position: Array
    orientation: Array
    gravity: Array
    softest: Array
    length: float
    unit: Array


class Room(NamedTuple):
    """Work arrays for the solution at one point, used again in each iteration."""

    wrench: Array
    change: Array
    gap: Array
    gap_before: Array
    step: Array
    tried: Array
    slope: Array


@compiled
def room() -> Room:
    """Work arrays for any point."""
    return Room(
        np.empty(6),
        np.empty(CHANGES),
        np.empty(6),
        np.empty(6),
        np.empty(6),
        np.empty(6),
        np.empty((6, 6)),
    )


@compiled
def settle(
    held: HeldPoints, known: bool, turning: Array, wrench: Array, settled: Flags, chord: Array
) -> None:
    """Fill the wrench (n, 6) that holds the tip, whether it belongs to an equilibrium (`settled`
    (n,)), and its change `chord` (n, 6, 6) with the pose of the tip.

    known: whether wrench and chord are filled with those of a similar hold, from which the search
    begins; if not, it begins from `turning` (n, 6), a moment that merely turns the tip as it is
    held (`turn_tips`). A chain that would curl up farther than any finger keeps `turning`, not
    settled.
    """
    rooms = room()
    for point in range(len(settled)):
        here, slope = wrench[point], chord[point]
        if abs(_curl(held, point)) > LARGEST_CURL:
            here[:], slope[:], settled[point] = turning[point], 0.0, False
            continue
        settled[point] = (
            (known and _by_chords(held, point, here, slope, rooms))
            or _by_newton(held, point, here, slope, 1.0, rooms)
            or _by_tightening(held, point, turning[point], here, slope, rooms)
        )


@compiled
def turn_tips(held: HeldPoints, turning: Array) -> None:
    """Fill `turning` (n, 6) with a moment that turns the tip to its held orientation, or less far
    if the springs are not equal about all axes.

    Far from the free pose the tip may turn either way round, or a turn more if the chain curls up
    far; the moment that brings the tip nearest to its position is taken.
    """
    rooms = room()
    for point in range(len(turning)):
        here, curl = turning[point], _curl(held, point)
        here[:] = 0.0
        if abs(curl) > LARGEST_CURL:
            _put_moment(held, point, (0.0, -curl, 0.0), here)
            continue
        _, free = _weightless(held, point, here, rooms)
        turn = rotation_vector(multiply(matrix_at(held.orientation, point), transposed(free)))
        _put_moment(held, point, turn, here)
        angle = np.sqrt(dot(turn, turn))
        if angle > AMBIGUOUS:
            nearest, rounds = _miss(held, point, here, rooms), 1 if abs(curl) < np.pi else 2
            for way in range(-rounds, rounds):
                rooms.tried[:3] = 0.0
                _put_moment(held, point, scaled(1.0 + 2.0 * np.pi * way / angle, turn), rooms.tried)
                miss = _miss(held, point, rooms.tried, rooms)
                if miss < nearest:
                    nearest = miss
                    here[:] = rooms.tried


@compiled
def _curl(held: HeldPoints, point: int) -> float:
    """Bend [rad] of the free chain."""
    total = 0.0
    for joint in range(len(held.links.mass)):
        total += held.springs.rest[joint, point]
    return total


@compiled
def _put_moment(held: HeldPoints, point: int, turn: Vector, wrench: Array) -> None:
    """The moment that turns the tip by a rotation vector [rad]."""
    for axis in range(3):
        wrench[3 + axis] = turn[axis] / held.softest[point] / held.unit[3]


@compiled
def _miss(held: HeldPoints, point: int, wrench: Array, rooms: Room) -> float:
    """Squared distance [m2] between the tip of the weightless chain and its held position."""
    place, _ = _weightless(held, point, wrench, rooms)
    way = minus(place, vector_at(held.position, point))
    return dot(way, way)


@compiled
def _weightless(held: HeldPoints, point: int, wrench: Array, rooms: Room) -> tuple[Vector, Matrix]:
    """Place and orientation of the tip of the weightless chain."""
    place, turn, _ = _march(held, point, wrench, False, False, rooms)
    return place, turn


@compiled
def _march(
    held: HeldPoints, point: int, wrench: Array, heavy: bool, sloped: bool, rooms: Room
) -> tuple[Vector, Matrix, Vector]:
    """Place, orientation and force at the tip."""
    given, change = rooms.wrench, rooms.change
    for component in range(6):
        given[component] = wrench[component] * held.unit[component]
    return march(held.links, held.springs, held.gravity, heavy, point, given, change, sloped)


@compiled
def _gap(
    held: HeldPoints, point: int, wrench: Array, softness: float, sloped: bool, rooms: Room
) -> float:
    """Size of the tip's pose against its hold; fills `gap`, and if sloped `slope`, its derivative
    by the wrench.

    The chain does not stretch, so a measured pose just out of its reach would take an infinite
    force. Therefore the clamp gives way a little, with the cube of the force: by a hundredth of the
    length at 40*B/L**2, ten times what blocks a finger.
    """
    heavy = held.gravity.shape[1] > 0
    place, turn, force = _march(held, point, wrench, heavy, sloped, rooms)
    strong = STRONG_FORCE * held.unit[0]
    relative = scaled(1.0 / strong, force)
    give = softness * CLAMP * STRONG_FORCE / 3.0 + YIELD * dot(relative, relative)
    way = scaled(1.0 / held.length, minus(place, vector_at(held.position, point)))
    way = plus(way, scaled(give, relative))
    error = rotation_vector(multiply(turn, transposed(matrix_at(held.orientation, point))))
    for axis in range(3):
        rooms.gap[axis], rooms.gap[3 + axis] = way[axis], error[axis]
    if sloped:
        _fill_slope(held, relative, give, error, rooms)
    return np.sqrt(dot(way, way) + dot(error, error))


@compiled
def _fill_slope(
    held: HeldPoints, relative: Vector, give: float, error: Vector, rooms: Room
) -> None:
    """The derivative of the gap by the wrench, all in the clamp's units."""
    slope, change, strong = rooms.slope, rooms.change, STRONG_FORCE * held.unit[0]
    for by in range(6):
        spin = change[SPIN, by, 0], change[SPIN, by, 1], change[SPIN, by, 2]
        # half of the logarithm's slope, which is the identity where the error has gone
        turned = minus(spin, scaled(0.5, cross(error, spin)))
        for axis in range(3):
            slope[axis, by] = change[POSITION_CHANGE, by, axis] / held.length
            if by < 3:
                slope[axis, by] += 2.0 * YIELD * relative[axis] * relative[by] / strong
            slope[3 + axis, by] = turned[axis]
        if by < 3:
            slope[by, by] += give / strong
        slope[:, by] *= held.unit[by]


@compiled
def _by_chords(held: HeldPoints, point: int, wrench: Array, chord: Array, rooms: Room) -> bool:
    """Converge in a few steps with the given chord, or leave wrench and chord unchanged.

    Each step mends the chord with what it has achieved (Broyden). The last step is not looked at
    any more: the one before it has shown what a step achieves.
    """
    tried, slope, gap, before = rooms.tried, rooms.slope, rooms.gap, rooms.gap_before
    tried[:], slope[:] = wrench, chord
    size = _gap(held, point, tried, 1.0, False, rooms)
    for _ in range(CHORDS):
        _follow(slope, gap, -1.0, rooms.step)
        tried += rooms.step
        before[:], size_before = gap, size
        size = _gap(held, point, tried, 1.0, False, rooms)
        for component in range(6):
            before[component] = gap[component] - before[component]
        _mend(slope, rooms.step, before)
        if size * min(size / max(size_before, POSE_ROUNDING), 1.0) < POSE_TOLERANCE:
            _follow(slope, gap, -1.0, rooms.step)
            tried += rooms.step
            chord[:] = slope
            if _is_credible(tried):
                wrench[:] = tried
                return True
            return False
        if not size < CHORD_PROGRESS * size_before:
            return False
    return False


@compiled
def _follow(chord: Array, gap: Array, sign: float, step: Array) -> None:
    """Fill the step (6,) of a chord for a gap."""
    for row in range(6):
        step[row] = 0.0
        for column in range(6):
            step[row] += sign * chord[row, column] * gap[column]


@compiled
def _mend(chord: Array, step: Array, rise: Array) -> None:
    """Update a chord (6, 6) such that it maps a change (6,) of the gap to the last step (6,).

    It stays as it is where that would turn it too far.
    """
    missed, back = np.zeros(6), np.zeros(6)
    _follow(chord, rise, 1.0, missed)
    along = square = 0.0
    for row in range(6):
        along += step[row] * missed[row]
        square += step[row] * step[row]
        for column in range(6):
            back[column] += step[row] * chord[row, column]
    if along > LEAST_MENDED * square and square > 0.0:
        for row in range(6):
            share = (step[row] - missed[row]) / along
            for column in range(6):
                chord[row, column] += share * back[column]


@compiled
def _is_credible(wrench: Array) -> bool:
    return max(abs(wrench[0]), abs(wrench[1]), abs(wrench[2])) <= LARGEST_FORCE


@compiled
def _by_newton(
    held: HeldPoints, point: int, wrench: Array, chord: Array, softness: float, rooms: Room
) -> bool:
    """Converge by damped Newton: a step that does not reduce the gap is shortened."""
    tried, step, best, share = rooms.tried, rooms.step, np.inf, 1.0
    step[:] = 0.0
    for _ in range(SHOOTING_STEPS):
        for component in range(6):
            tried[component] = wrench[component] - share * step[component]
        size = _gap(held, point, tried, softness, True, rooms)
        if size < best:
            best, share = size, min(4.0 * share, 1.0)
            wrench[:] = tried
            invert(rooms.slope, chord)
            _follow(chord, rooms.gap, 1.0, step)
            longest = LARGEST_WRENCH_STEP
            for component in range(6):
                longest = max(longest, abs(step[component]))
            step *= LARGEST_WRENCH_STEP / longest
        else:
            share *= 0.25
        if not (best > POSE_TOLERANCE and share > SHORTEST_SHARE):
            break
    return _is_credible(wrench) and best <= REACHED_POSE


@compiled
def _by_tightening(
    held: HeldPoints, point: int, start: Array, wrench: Array, chord: Array, rooms: Room
) -> bool:
    """Solve with a soft clamp, then with stiffer and stiffer ones, each from the wrench (6,) of the
    last; false if one does not converge.
    """
    there, slope = start.copy(), chord.copy()
    for softness in SOFTER:
        if not _by_newton(held, point, there, slope, softness, rooms):
            return False
        wrench[:], chord[:] = there, slope
    return True


@compiled
def invert(matrix: Array, inverse: Array) -> None:
    """Fill the inverse of a square matrix by Gauss-Jordan elimination with column pivots."""
    left, size = matrix.copy(), len(matrix)
    inverse[:] = np.eye(size)
    for column in range(size):
        pivot = column + np.argmax(np.abs(left[column:, column]))
        for row in range(size):  # of both, the pivot's comes to its place
            left[column, row], left[pivot, row] = left[pivot, row], left[column, row]
            inverse[column, row], inverse[pivot, row] = inverse[pivot, row], inverse[column, row]
        share = 1.0 / left[column, column]
        left[column] *= share
        inverse[column] *= share
        for row in range(size):
            if row != column:
                share = left[row, column]
                left[row] -= share * left[column]
                inverse[row] -= share * inverse[column]
