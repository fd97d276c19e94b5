"""Shooting solver: base wrench for a prescribed tip pose."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from softhand_model.chain.segments import SegmentChain
from softhand_model.equilibrium.joint_springs import JointSprings
from softhand_model.numerics.arrays import Array, Flags, Indices
from softhand_model.numerics.rotations import (
    cross,
    cross_matrix,
    exponentials,
    identity,
    product,
    rotation_vectors,
    rotations,
    transposed,
    turned,
    turned_back,
)

CLAMP = 1e-7  # compliance of the tip's clamp over that of the chain as a cantilever
STRONG_FORCE = 40.0  # [B/L**2] at which the clamp has yielded by YIELD
YIELD = 0.01  # [lengths of the chain], with the cube of the force
LARGEST_FORCE = 60.0  # [B/L**2]: more comes from equilibria that tear the tip out of its clamp
TOLERANCE = 1e-11  # of the tip's pose, in lengths of the chain and radians
REACHED = 1e-9  # the same of a pose where rounding stops the iteration
STEPS = 80
LARGEST_STEP = 3.0  # of the wrench, in units of B/L**2 and B/L
SHORTEST_SHARE = 1e-3  # of a Newton step
LEAST_MENDED = 0.1  # share of its length that a chord keeps along the last step
ROUNDING = 1e-15  # of the tip's pose
CHORDS = 8  # steps with a slope from elsewhere before it is given up
CHORD_PROGRESS = 0.3  # by which each must bring the tip nearer
SOFTER = (1e6, 1e5, 1e4, 1e3, 1e2, 1e1, 1.0)  # clamps on the way to poses that are hard to find


@dataclass(frozen=True)
class Links:
    """Links of a straight chain with n joints: along (n + 1,) [m] from base to joint, from joint to
    joint and to the tip; mass (n,) [kg] and centre (n, 3) [m] of each in its own frame.
    """

    along: Array
    mass: Array
    center: Array


def straight_links(chain: SegmentChain) -> Links:
    """The links of a chain; raises ValueError for one that is not straight at rest."""
    chain.require_straight()
    along = np.append(chain.offset[:, 2], chain.tip_offset[2])
    return Links(along, chain.mass, chain.body_center)


class Front:
    """What the chain has come to at one of its points.

    orientation (3, 3, n), place (3, n) [m]: of the frame; force [N], moment [N m] (3, n): of all
    that lies beyond, the moment about the base's origin.
    """

    def __init__(self, wrench: Array) -> None:
        points = wrench.shape[1]
        self.force, self.moment = wrench[:3], wrench[3:]
        self.orientation, self.place = identity(points), np.zeros((3, points))

    def follow(self, links: Links, springs: JointSprings, gravity: Array | None) -> Front:
        """Go on to the tip, under gravity (3, n) [m/s2] or none."""
        for joint, mass in enumerate(links.mass):
            self._advance(links.along[joint])
            self._bend(springs, joint)
            if gravity is not None:
                self._unload(mass * gravity, links.center[joint])
        self._advance(links.along[-1])
        return self

    def _advance(self, length: float) -> Array:
        """Go on along the link; what has been gone (3, n) [m]."""
        reach = length * self.orientation[:, 2]
        self.place = self.place + reach
        return reach

    def _bend(self, springs: JointSprings, joint: int) -> None:
        """Pass a joint, whose spring carries what lies beyond."""
        moment = self.moment - cross(self.place, self.force)
        if springs.isotropic:  # it rotates about the moment, in any frame
            bent = product(rotations(springs.rotation(joint, moment)), self.orientation)
            self.orientation = _about_y(bent, *springs.rest_sine_cosine(joint))
            return
        rest = _about_y(self.orientation, *springs.rest_sine_cosine(joint))
        rotation = springs.rotation(joint, turned_back(rest, moment))
        self.orientation = product(rest, rotations(rotation))

    def _unload(self, weight: Array, center: Array) -> Array:
        """Leave a link behind: its weight (3, n) [N] at a centre (3,) [m]; the arm (3, n) [m]."""
        arm = turned(self.orientation, center[:, None])
        self.moment = self.moment - cross(self.place + arm, weight)
        self.force = self.force - weight
        return arm


class SlopedFront(Front):
    """A front with its derivatives by the six components of the wrench at the base.

    spin (3, 6, n) [rad], shift (3, 6, n) [m], by_moment (3, 6, n) [N m]: changes of orientation,
    place and moment; the force changes as the one at the base does.
    """

    def __init__(self, wrench: Array) -> None:
        super().__init__(wrench)
        points = wrench.shape[1]
        self.spin, self.shift = np.zeros((3, 6, points)), np.zeros((3, 6, points))
        self.by_moment = np.zeros((3, 6, points))
        self.by_moment[:, 3:] = np.eye(3)[:, :, None]

    def _advance(self, length: float) -> Array:
        reach = super()._advance(length)
        self.shift = self.shift + cross(self.spin, reach[:, None])
        return reach

    def _bend(self, springs: JointSprings, joint: int) -> None:
        moment = self.moment - cross(self.place, self.force)
        change = self.by_moment - cross(self.shift, self.force[:, None])
        change[:, :3] -= cross_matrix(self.place)
        change -= cross(self.spin, moment[:, None])
        rest = _about_y(self.orientation, *springs.rest_sine_cosine(joint))
        local = turned_back(rest, moment)
        rotation = springs.rotation(joint, local)
        exponential, jacobian = exponentials(rotation)
        self.orientation = product(rest, exponential)
        inward = product(jacobian, springs.compliance(joint, rotation, local))
        outward = product(product(rest, inward), transposed(rest))
        self.spin = self.spin + turned(outward, change)

    def _unload(self, weight: Array, center: Array) -> Array:
        arm = super()._unload(weight, center)
        moved = self.shift + cross(self.spin, arm[:, None])
        self.by_moment = self.by_moment - cross(moved, weight[:, None])
        return arm


def _about_y(matrix: Array, sine: Array, cosine: Array) -> Array:
    """Rotations (3, 3, n) followed by one about their y of this sine and cosine (n,)."""
    x, z = matrix[:, 0], matrix[:, 2]
    result = np.empty_like(matrix)
    result[:, 0] = cosine * x - sine * z
    result[:, 1] = matrix[:, 1]
    result[:, 2] = sine * x + cosine * z
    return result


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


@dataclass
class Search:
    """What has been found at n points: wrench (6, n) in the clamp's units, whether it is that of an
    equilibrium (n,), and chord (n, 6, 6), its change with the pose of the tip.
    """

    wrench: Array
    settled: Flags
    chord: Array


class TipClamp:
    """What holds the tip of a chain. Lengths are in those of the chain, wrenches in `unit` (6, 1):
    B/L**2 [N] and B/L [N m], with B from the stiffness (joints,) [N m/rad] of the joints.

    The chain does not stretch, so a measured pose just out of its reach would take an infinite
    force. Therefore the clamp gives way a little, with the cube of the force: by a hundredth of the
    length at 40*B/L**2, ten times what blocks a finger.
    """

    def __init__(self, links: Links, stiffness: Array) -> None:
        self.links = links
        self._length = float(np.sum(links.along))
        force = 1.0 / float(np.sum(1.0 / stiffness)) / self._length
        self.unit = np.repeat([force, force * self._length], 3)[:, None]

    def gap(self, hold: Hold, wrench: Array, softness: float = 1.0) -> Array:
        """Pose of the tip against its hold (6, n): lengths of the chain, radians."""
        front = Front(wrench * self.unit).follow(self.links, hold.springs, hold.gravity)
        return self._against(hold, front, self._yielded(front.force, softness))

    def sloped_gap(self, hold: Hold, wrench: Array, softness: float = 1.0) -> tuple[Array, Array]:
        """The gap, and its derivative (n, 6, 6) by the wrench."""
        front = SlopedFront(wrench * self.unit)
        front.follow(self.links, hold.springs, hold.gravity)
        gap = self._against(hold, front, self._yielded(front.force, softness))
        # half of the logarithm's slope, which is the identity where the error has gone
        spin = front.spin - 0.5 * cross(gap[3:, None], front.spin)
        shift = front.shift / self._length
        shift[:, :3] += self._slack(front.force, softness)
        slope = np.concatenate([shift, spin]) * self.unit
        return gap, np.ascontiguousarray(np.moveaxis(slope, -1, 0))

    def _against(self, hold: Hold, front: Front, yielded: Array) -> Array:
        place = (front.place - hold.position) / self._length + yielded
        error = rotation_vectors(product(front.orientation, transposed(hold.orientation)))
        return np.concatenate([place, error])

    def _yielded(self, force: Array, softness: float) -> Array:
        """What the clamp yields (3, n) [lengths of the chain] to a force (3, n) [N]."""
        relative = force / (STRONG_FORCE * self.unit[0])
        linear = softness * CLAMP * STRONG_FORCE / 3.0
        return (linear + YIELD * np.sum(relative * relative, axis=0)) * relative

    def _slack(self, force: Array, softness: float) -> Array:
        """Derivative (3, 3, n) of what the clamp yields [lengths of the chain/N]."""
        relative = force / (STRONG_FORCE * self.unit[0])
        slack = 2.0 * YIELD * relative[:, None] * relative[None]
        linear = softness * CLAMP * STRONG_FORCE / 3.0
        slack[[0, 1, 2], [0, 1, 2]] += linear + YIELD * np.sum(relative * relative, axis=0)
        return slack / (STRONG_FORCE * self.unit[0])


def by_chords(clamp: TipClamp, hold: Hold, search: Search) -> None:
    """Settle what a few steps with the given chords settle; leave the rest as it was.

    Each step mends the chord with what it has achieved (Broyden). The last step is not looked at
    any more: the one before it has shown what a step achieves.
    """
    active, wrench, chord = np.arange(len(search.settled)), search.wrench, search.chord
    gap, part = clamp.gap(hold, wrench), hold
    size = _size(gap)
    for _ in range(CHORDS):
        step = -np.einsum("nij,jn->in", chord, gap)
        wrench = wrench + step
        gap_before, before = gap, size
        gap = clamp.gap(part, wrench)
        size = _size(gap)
        chord = _mended(chord, step, gap - gap_before)
        last = -np.einsum("nij,jn->in", chord, gap)
        done = size * np.minimum(size / np.maximum(before, ROUNDING), 1.0) < TOLERANCE
        _settle(search, active[done], wrench[:, done] + last[:, done])
        search.chord[active[done]] = chord[done]
        goes_on = np.flatnonzero(~done & (size < CHORD_PROGRESS * before))
        if not len(goes_on):
            break
        active, wrench, chord = active[goes_on], wrench[:, goes_on], chord[goes_on]
        gap, size, part = gap[:, goes_on], size[goes_on], part.take(goes_on)


def _size(gap: Array) -> Array:
    return np.asarray(np.sqrt(np.sum(gap * gap, axis=0)))


def _mended(chord: Array, step: Array, rise: Array) -> Array:
    """Chords (n, 6, 6) that lead a rise (6, n) of the gap back to the step (6, n) behind it.

    They stay as they are where that would turn them too far.
    """
    missed = np.einsum("nij,jn->ni", chord, rise)
    back = np.einsum("in,nij->nj", step, chord)
    along = np.einsum("in,ni->n", step, missed)
    square = np.sum(step * step, axis=0)
    safe = (along > LEAST_MENDED * square) & (square > 0.0)
    share = (step.T - missed) / np.where(safe, along, np.inf)[:, None]
    return chord + share[:, :, None] * back[:, None]


def by_newton(clamp: TipClamp, hold: Hold, search: Search, softness: float = 1.0) -> None:
    """Settle by damped Newton: a step that does not bring the tip nearer is taken back and cut."""
    best = np.where(search.settled, 0.0, np.inf)
    step, share = np.zeros_like(search.wrench), np.ones(len(best))
    active = np.flatnonzero(~search.settled)
    part = hold.take(active)
    for _ in range(STEPS):
        if not len(active):
            break
        tried = search.wrench[:, active] - share[active] * step[:, active]
        gap, slope = clamp.sloped_gap(part, tried, softness)
        size = _size(gap)
        nearer = size < best[active]
        moved = active[nearer]
        search.wrench[:, moved], best[moved] = tried[:, nearer], size[nearer]
        search.chord[moved] = np.linalg.inv(slope[nearer])
        step[:, moved] = _newton_step(search.chord[moved], gap[:, nearer])
        share[moved] = np.minimum(4.0 * share[moved], 1.0)
        share[active[~nearer]] *= 0.25
        still = (best[active] > TOLERANCE) & (share[active] > SHORTEST_SHARE)
        if not still.all():
            active = active[still]
            part = hold.take(active)
    credible = np.max(np.abs(search.wrench[:3]), axis=0) <= LARGEST_FORCE
    search.settled = credible & (best <= REACHED)


def by_tightening(clamp: TipClamp, hold: Hold, search: Search, start: Array) -> None:
    """Settle what is left from a first guess (6, n), with a soft clamp that is tightened."""
    follows = np.flatnonzero(~search.settled)
    wrench = start[:, follows]
    for softness in SOFTER:
        part = Search(wrench, np.zeros(len(follows), bool), search.chord[follows])
        by_newton(clamp, hold.take(follows), part, softness)
        follows, wrench = follows[part.settled], part.wrench[:, part.settled]
        search.wrench[:, follows], search.chord[follows] = wrench, part.chord[part.settled]
    search.settled[follows] = True


def _settle(search: Search, points: Indices, wrench: Array) -> None:
    credible = np.max(np.abs(wrench[:3]), axis=0, initial=0.0) <= LARGEST_FORCE
    search.settled[points] = credible
    search.wrench[:, points[credible]] = wrench[:, credible]


def _newton_step(inverse: Array, gap: Array) -> Array:
    """Step (6, n) that closes the gap to first order, cut to LARGEST_STEP."""
    step = np.einsum("nij,jn->in", inverse, gap)
    size = np.max(np.abs(step), axis=0, initial=0.0)
    return step * np.minimum(1.0, LARGEST_STEP / np.maximum(size, LARGEST_STEP))
