"""Equilibrium in space of a straight chain that is held at its base and at its tip.

The rotation of a joint follows from the wrench at the base and from the joints before it, so the
six components of that wrench are the only unknowns, whatever the number of joints; the pose of the
tip gives the six equations. All points (samples, trial values) are solved at once and lie last in
every array. Everything is in the frame of the chain's base: z along it, x to the bending side.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from softhand_model.joint_springs import JointSprings
from softhand_model.segments import SegmentChain
from softhand_model.vector_fields import (
    cross,
    exponentials,
    identity,
    product,
    rotation_vectors,
    transposed,
    turned,
    turned_back,
)

Array = NDArray[np.float64]
Indices = NDArray[np.intp]
Flags = NDArray[np.bool_]

CLAMP = 1e-7  # compliance of the tip's clamp over that of the chain as a cantilever
STRONG_FORCE = 40.0  # [B/L**2] at which the clamp has yielded by YIELD
YIELD = 0.01  # [lengths of the chain], with the cube of the force
TOLERANCE = 1e-11  # of the tip's pose, in lengths of the chain and radians
LARGEST_FORCE = 60.0  # [B/L**2]: more comes from equilibria that tear the tip out of its clamp
AMBIGUOUS = 0.6  # [rad]: a turn less far than this is not taken to go the other way round
REACHED = 1e-9  # the same of a pose where rounding stops the iteration
STEPS = 80
LARGEST_STEP = 3.0  # of the wrench, in units of B/L**2 and B/L
SHORTEST_SHARE = 1e-3  # of a Newton step
AT_ONCE = 6000  # points, so that memory stays bounded
SOFTER = (1e6, 1e5, 1e4, 1e3, 1e2, 1e1, 1.0)  # clamps on the way to poses that are hard to find


@dataclass(frozen=True)
class Hold:
    """Where the tip is held, at n points: position (3, n) [m] and orientation (3, 3, n); gravity
    (3, n) [m/s2], or none.
    """

    springs: JointSprings
    position: Array
    orientation: Array
    gravity: Array | None = None

    def take(self, chosen: Indices) -> Hold:
        """Some of the points."""
        return Hold(
            self.springs.take(chosen),
            self.position[:, chosen],
            self.orientation[:, :, chosen],
            None if self.gravity is None else self.gravity[:, chosen],
        )


@dataclass(frozen=True)
class BaseLoad:
    """What a chain exerts on its base at n points: wrench (6, n), force [N] and torque [N m] about
    the base's origin.

    beyond (6, n): the wrench less a moment that would merely turn the tip as it is held.
    settled (n,): whether the equilibrium was found; elsewhere the load is that of a softer clamp,
    as far as one led to an equilibrium.
    """

    wrench: Array
    beyond: Array
    settled: Flags

    @property
    def force(self) -> Array:
        """Force (3, n) [N]."""
        return self.wrench[:3]

    @property
    def torque(self) -> Array:
        """Torque (3, n) [N m]."""
        return self.wrench[3:]

    def repeated(self, times: int) -> BaseLoad:
        """The loads several times, one after the other."""
        wrench, beyond = (np.tile(part, (1, times)) for part in (self.wrench, self.beyond))
        return BaseLoad(wrench, beyond, np.tile(self.settled, times))


class HeldChain:
    """A straight chain as the simulator has it, held at both ends.

    The chain does not stretch, so a measured pose just out of its reach would take an infinite
    force. Therefore the clamp at the tip gives way a little, with the cube of the force: by a
    hundredth of the length at 40*B/L**2, ten times what blocks a finger.

    Raises ValueError for a chain that is not straight at rest.
    """

    def __init__(self, chain: SegmentChain) -> None:
        if np.any(chain.offset[:, :2]) or np.any(chain.rest[:, :3]) or np.any(chain.tip_offset[:2]):
            raise ValueError("chain: expected one that is straight at rest, got an arc")
        self._along = np.append(chain.offset[:, 2], chain.tip_offset[2])
        self._mass, self._center = chain.mass, chain.body_center
        length = float(np.sum(self._along))
        bending = length / float(np.sum(1.0 / chain.stiffness[:, 1]))
        self._length, self._force = length, bending / length**2
        self._clamp = CLAMP * length / self._force / 3.0
        self._unit = np.repeat([self._force, self._force * length], 3)[:, None]

    def base_load(self, hold: Hold, like: BaseLoad | None = None) -> BaseLoad:
        """What the chain exerts on its base in equilibrium, at every point.

        like: loads of similar holds, from which the search begins.
        """
        points = hold.position.shape[1]
        wrench, beyond = np.empty((6, points)), np.zeros((6, points))
        settled = np.empty(points, bool)
        for first in range(0, points, AT_ONCE):
            part = np.arange(first, min(first + AT_ONCE, points))
            held = hold.take(part)
            turning = self._turning(held)
            start = turning if like is None else turning + like.beyond[:, part] / self._unit
            wrench[:, part], settled[part] = self._found(held, start)
            beyond[:, part] = wrench[:, part] - turning
        return BaseLoad(wrench * self._unit, beyond * self._unit, settled)

    def _turning(self, hold: Hold) -> Array:
        """Wrench (6, n) in its units to begin with: a moment that turns the tip as it is held.

        Far from the free pose it may turn either way round: the one that brings the tip nearer.
        """
        weightless = replace(hold, gravity=None)
        free = self._front(weightless, np.zeros((6, hold.position.shape[1])))
        turn = rotation_vectors(product(hold.orientation, transposed(free.turn)))
        wrench = self._moment(hold, turn)
        far = np.flatnonzero(np.sum(turn * turn, axis=0) > AMBIGUOUS**2)
        if len(far):
            part, angle = weightless.take(far), np.sqrt(np.sum(turn[:, far] ** 2, axis=0))
            other = self._moment(part, turn[:, far] * (1.0 - 2.0 * np.pi / angle))
            misses = [
                np.sum((self._front(part, way).place - part.position) ** 2, axis=0)
                for way in (wrench[:, far], other)
            ]
            wrench[:, far] = np.where(misses[1] < misses[0], other, wrench[:, far])
        return wrench

    def _moment(self, hold: Hold, turn: Array) -> Array:
        """Wrench (6, n) in its units that turns the tip by a rotation vector (3, n) [rad]."""
        moment = turn / np.sum(1.0 / hold.springs.stiffness, axis=0) / self._unit[3:]
        return np.concatenate([np.zeros_like(moment), moment])

    def _found(self, hold: Hold, start: Array) -> tuple[Array, Flags]:
        """Wrench (6, n) in its units, and where it is that of an equilibrium."""
        wrench, settled = self._newton(hold, start, 1.0)
        missed = np.flatnonzero(~settled)
        if len(missed):
            wrench[:, missed], settled[missed] = self._tightened(hold.take(missed))
        return wrench, settled

    def _tightened(self, hold: Hold) -> tuple[Array, Flags]:
        """As `_newton`, with a soft clamp first that is tightened as long as that succeeds."""
        wrench = self._turning(hold)
        follows = np.arange(wrench.shape[1])
        for softness in SOFTER:
            tighter, settled = self._newton(hold.take(follows), wrench[:, follows], softness)
            follows = follows[settled]
            wrench[:, follows] = tighter[:, settled]
        held = np.zeros(wrench.shape[1], bool)
        held[follows] = True
        return wrench, held

    def _newton(self, hold: Hold, wrench: Array, softness: float) -> tuple[Array, Flags]:
        """Wrench (6, n) in its units by damped Newton from a first guess, and where it settled.

        A step that does not bring the tip nearer is taken back and halved.
        """
        wrench = wrench.copy()
        best = np.full(wrench.shape[1], np.inf)
        step, share = np.zeros_like(wrench), np.ones(wrench.shape[1])
        active, part = np.arange(len(best)), hold
        for _ in range(STEPS):
            tried = wrench[:, active] - share[active] * step[:, active]
            gap, slope = self._gap(part, tried, softness)
            size = np.sqrt(np.sum(gap * gap, axis=0))
            nearer = size < best[active]
            moved = active[nearer]
            wrench[:, moved], best[moved] = tried[:, nearer], size[nearer]
            step[:, moved] = _newton_step(slope[:, :, nearer], gap[:, nearer])
            share[moved] = np.minimum(4.0 * share[moved], 1.0)
            share[active[~nearer]] *= 0.25
            still = (best[active] > TOLERANCE) & (share[active] > SHORTEST_SHARE)
            if not still.any():
                break
            if not still.all():
                active = active[still]
                part = hold.take(active)
        credible = np.max(np.abs(wrench[:3]), axis=0) <= LARGEST_FORCE
        return wrench, credible & (best <= REACHED)

    def _gap(self, hold: Hold, wrench: Array, softness: float) -> tuple[Array, Array]:
        """Pose of the tip against its hold (6, n) [lengths, rad], and its slope (6, 6, n)."""
        front = self._front(hold, wrench)
        yielded, slack = self._yielded(front.force, softness)
        place = (front.place + yielded - hold.position) / self._length
        error = rotation_vectors(product(front.turn, transposed(hold.orientation)))
        shift = (front.shift + turned(slack, front.by_force)) / self._length
        # half of the logarithm's slope, which is the identity where the error has gone
        spin = front.spin - 0.5 * cross(error[:, None], front.spin)
        return np.concatenate([place, error]), np.concatenate([shift, spin])

    def _front(self, hold: Hold, wrench: Array) -> _Front:
        """The tip under a wrench (6, n) at the base."""
        front = _Front(wrench, self._unit)
        for joint, mass in enumerate(self._mass):
            front.advance(self._along[joint])
            front.bend(hold.springs, joint)
            if hold.gravity is not None:
                front.unload(mass * hold.gravity, self._center[joint])
        front.advance(self._along[-1])
        return front

    def _yielded(self, force: Array, softness: float) -> tuple[Array, Array]:
        """What the clamp yields (3, n) [m] to a force (3, n) [N], and its slope (3, 3, n)."""
        relative = force / (STRONG_FORCE * self._force)
        cubic = YIELD * self._length / (STRONG_FORCE * self._force)
        slack = 2.0 * cubic * relative[:, None] * relative[None]
        grown = softness * self._clamp + cubic * np.sum(relative * relative, axis=0)
        slack[[0, 1, 2], [0, 1, 2]] += grown
        return grown * force, slack


class _Front:
    """What the chain has come to at one of its points, and how that changes with the wrench at its
    base.

    turn (3, 3, n), place (3, n) [m]; force, moment (3, n): of all that lies beyond, the moment
    about the base's origin [N], [N m]. spin (3, 6, n) [rad], shift (3, 6, n) [m], by_force,
    by_moment (3, 6, n): their changes with the six components of the wrench.
    """

    def __init__(self, wrench: Array, unit: Array) -> None:
        points = wrench.shape[1]
        self.force, self.moment = wrench[:3] * unit[:3], wrench[3:] * unit[3:]
        self.turn, self.place = identity(points), np.zeros((3, points))
        self.spin, self.shift = np.zeros((3, 6, points)), np.zeros((3, 6, points))
        self.by_force, self.by_moment = (np.zeros((3, 6, points)) for _ in range(2))
        self.by_force[:, :3] = unit[0] * np.eye(3)[:, :, None]
        self.by_moment[:, 3:] = unit[3] * np.eye(3)[:, :, None]

    def advance(self, length: float) -> None:
        """Go on along the link."""
        reach = length * self.turn[:, 2]
        self.place = self.place + reach
        self.shift = self.shift + cross(self.spin, reach[:, None])

    def bend(self, springs: JointSprings, joint: int) -> None:
        """Pass a joint: its spring carries what lies beyond."""
        moment = self.moment - cross(self.place, self.force)
        change = (
            self.by_moment
            - cross(self.shift, self.force[:, None])
            - cross(self.place[:, None], self.by_force)
        )
        rest = _about_y(self.turn, springs.rest[joint])
        rotation, compliance = springs.rotate(joint, turned_back(rest, moment))
        exponential, jacobian = exponentials(rotation)
        self.turn = product(rest, exponential)
        outward = product(product(rest, product(jacobian, compliance)), transposed(rest))
        self.spin = self.spin + turned(outward, change - cross(self.spin, moment[:, None]))

    def unload(self, weight: Array, center: Array) -> None:
        """Leave a link behind: its weight (3, n) [N] at a centre (3,) [m] in its frame."""
        arm = turned(self.turn, center[:, None])
        self.moment = self.moment - cross(self.place + arm, weight)
        moved = self.shift + cross(self.spin, arm[:, None])
        self.by_moment = self.by_moment - cross(moved, weight[:, None])
        self.force = self.force - weight


def _newton_step(slope: Array, gap: Array) -> Array:
    """Solution (6, n) of slope @ step = gap, cut to LARGEST_STEP."""
    columns = np.moveaxis(gap, -1, 0)[:, :, None]
    step = np.linalg.solve(np.moveaxis(slope, -1, 0), columns)[:, :, 0].T
    size = np.max(np.abs(step), axis=0)
    return step * np.minimum(1.0, LARGEST_STEP / np.maximum(size, LARGEST_STEP))


def _about_y(turn: Array, angle: Array) -> Array:
    """Rotations (3, 3, n) followed by a turn (n,) [rad] about their y."""
    sine, cosine = np.sin(angle), np.cos(angle)
    x, z = turn[:, 0], turn[:, 2]
    return np.stack([cosine * x - sine * z, turn[:, 1], sine * x + cosine * z], axis=1)
