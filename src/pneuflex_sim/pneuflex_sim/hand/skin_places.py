"""Places on the skin of straight actuators: distance along, distance around, and side.

A place is `along` [m] from the base of the rubber, and `around` [m] along the outline of the
section there, from the middle of the passive layer towards +y. The sides of an actuator are its
`pad` (the passive layer), its `back`, and its flanks `+y` and `-y`; +y is the thumb's side of a
right hand.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from pneuflex_sim.hand.kinematics import HandShape
from softhand_common.numerics.arrays import Array
from softhand_model.chain.hulls import SMALLEST_EDGE
from softhand_model.chain.outline import ChainOutline, cross_section

Section = Callable[[ChainOutline, float], Array]  # points (k, 2) [m] of the section at a place [m]

PAD, BACK, LEFT, RIGHT, TIP = "pad", "back", "+y", "-y", "tip"


@dataclass(frozen=True)
class SkinPlace:
    """A place on the skin of a chain.

    Attributes:
        chain: name of the chain.
        along, around: distances [m] from the base and from the middle of the passive layer, see the
            module.
        side: the side whose normal is within 45 deg of the skin's normal.
        length: length of the chain [m].
        girth: circumference of the section [m].
        flank: `around` at the middle of the +y side [m].
    """

    chain: str
    along: float
    around: float
    side: str
    length: float
    girth: float
    flank: float

    def distance(self, share: float, side: str) -> float:
        """Distance [m] along the skin to the middle of a side at a share of the length; to the
        `tip`, the shorter of the distances over pad and back.

        >>> place = SkinPlace("index", 0.075, 0.003, "pad", 0.1, 0.06, 0.011)
        >>> round(place.distance(0.79, "pad"), 6), round(place.distance(0.75, "+y"), 6)
        (0.005, 0.008)
        """
        middles = {PAD: (0.0,), BACK: (0.5,), LEFT: (0.0,), RIGHT: (0.0,), TIP: (0.0, 0.5)}[side]
        shift = {LEFT: self.flank, RIGHT: -self.flank}.get(side, 0.0)
        aside = min(abs(self._wrapped(m * self.girth + shift - self.around)) for m in middles)
        return float(np.hypot(self.along - share * self.length, aside))

    def _wrapped(self, difference: float) -> float:
        return (difference + 0.5 * self.girth) % self.girth - 0.5 * self.girth


class SkinPlaces:
    """Converts between points and places on the skin of a hand's straight single actuators; points
    [m] in the wrist frame, joint orientations q (n, 4).
    """

    def __init__(self, shape: HandShape) -> None:
        self._shape, layout = shape, shape.layout
        self._outlines = {
            chain.name: ChainOutline(chain, layout.segments)
            for chain in layout.description.chains
            if not chain.turn and not chain.pitch
        }

    @property
    def chains(self) -> tuple[str, ...]:
        """Names of the chains that have such a skin."""
        return tuple(self._outlines)

    def length(self, chain: str) -> float:
        """Length [m] of a chain's rubber."""
        return self._outlines[chain].length

    def locate(self, chain: str, point: Array, q: Array) -> SkinPlace:
        """The place on a chain's skin that is next to a point."""
        outline, nearest = self._outlines[chain], (np.inf, 0.0, 0, 0.0, np.empty((0, 2)))
        for beyond, along, flat in self._beside(chain, point, q):
            if beyond >= nearest[0]:
                break
            ring = _ring(outline, along)
            gap, edge, around = _nearest(ring, flat)
            far = float(np.hypot(gap, beyond))
            if far < nearest[0]:
                nearest = (far, along, edge, around, ring)
        _, along, edge, around, ring = nearest
        girth, flank = _girth(ring)
        signed = around if around <= 0.5 * girth else around - girth
        side = _side(ring, edge)
        return SkinPlace(chain, along, signed, side, outline.length, girth, flank)

    def points(self, chain: str, along: Array, q: Array) -> Array:
        """Points (len(along) * k, 3) [m] of the skin's outlines at distances `along` [m] from the
        base of a chain.
        """
        return np.vstack([self._placed(*self.outline(chain, at), q) for at in along])

    def point(self, chain: str, share: float, side: str, q: Array) -> Array:
        """Point (3,) [m] in the middle of a side, or of the `tip`, at a share of a chain's
        length.
        """
        return self._placed(*self.middle(chain, share, side), q)[0]

    def outline(self, chain: str, along: float) -> tuple[int, Array]:
        """The joint that carries the skin's outline at a distance `along` [m] from the base of a
        chain, and the outline's points (k, 3) [m] in the frame of that joint.
        """
        return self._carried(chain, along, _ring)

    def middle(self, chain: str, share: float, side: str) -> tuple[int, Array]:
        """As `outline`, of the one point in the middle of a side, see `point`."""

        def section(outline: ChainOutline, along: float) -> Array:
            """The side's middle in the section (1, 2) [m]."""
            height, width = np.maximum(outline.extents(along)[0], SMALLEST_EDGE)
            flank = [-0.3 * height, 0.5 * width]  # as `_girth` has it
            return np.array(
                [
                    {BACK: [-height, 0.0], LEFT: flank, RIGHT: [flank[0], -flank[1]]}.get(
                        side, [0.0, 0.0]
                    )
                ]
            )

        return self._carried(chain, share * self.length(chain), section)

    def _placed(self, joint: int, points: Array, q: Array) -> Array:
        position, frame, _ = self._shape.frames(q)
        return np.asarray(position[joint] + points @ frame[joint].T)

    def _carried(self, chain: str, along: float, section: Section) -> tuple[int, Array]:
        outline = self._outlines[chain]
        for bone, joint, lift in self._carriers(chain):
            if along <= outline.range(bone)[1] + 1e-9:
                flat = section(outline, along)
                z = np.full((len(flat), 1), along - outline.joint(bone))
                return joint, np.hstack([flat, z]) + lift
        raise ValueError(f"along: expected at most {outline.length} m, got {along}")

    def _beside(self, chain: str, point: Array, q: Array) -> list[tuple[float, float, Array]]:
        """For each bone, nearest first: how far [m] a point is beyond its ends, the nearest place
        along the chain, and the point (2,) [m] in the section there.
        """
        outline, found = self._outlines[chain], []
        for bone, origin, axes in self._bones(chain, q):
            x, y, z = axes.T @ (point - origin)
            low, high = np.array(outline.range(bone)) - outline.joint(bone)
            inside = float(np.clip(z, low, high))
            found.append((abs(z - inside), outline.joint(bone) + inside, np.array([x, y])))
        return sorted(found, key=lambda one: one[0])

    def _bones(self, chain: str, q: Array) -> list[tuple[int, Array, Array]]:
        """Number, origin and axes of each bone of a chain that has rubber."""
        position, frame, _ = self._shape.frames(q)
        return [
            (bone, position[joint] + frame[joint] @ lift, frame[joint])
            for bone, joint, lift in self._carriers(chain)
        ]

    def _carriers(self, chain: str) -> list[tuple[int, int, Array]]:
        """Number of each bone that has rubber, its joint, and the bone's origin in that frame."""
        joints, outline = self._shape.layout.chain_joints[chain], self._outlines[chain]
        strut, first, found = outline.description.strut, joints.start, []
        if strut is not None:
            lift = np.array([0.0, 0.0, strut.length / 2.0 + outline.edge / 2.0])
            found.append((0, first, lift))
            first += 1
        return found + [
            (bone, first + bone - 1, np.zeros(3)) for bone in range(1, outline.segments + 1)
        ]


def _ring(outline: ChainOutline, along: float) -> Array:
    """Outline (k, 2) [m] of the section at a place, from the corner of the passive layer at +y."""
    return np.asarray(outline.outlines(along, cross_section(), SMALLEST_EDGE)[0])


def _nearest(ring: Array, point: Array) -> tuple[float, int, float]:
    """Distance [m] of a point from an outline, the nearest edge, and how far [m] around it is from
    the middle of the passive layer, which is the last edge.
    """
    edges = np.roll(ring, -1, axis=0) - ring
    lengths = np.linalg.norm(edges, axis=1)
    share = np.clip(np.einsum("ij,ij->i", point - ring, edges) / lengths**2, 0.0, 1.0)
    gaps = np.linalg.norm(ring + share[:, None] * edges - point, axis=1)
    edge = int(np.argmin(gaps))
    start = 0.5 * lengths[-1] + np.concatenate([[0.0], np.cumsum(lengths)[:-1]])
    around = (start[edge] + share[edge] * lengths[edge]) % lengths.sum()
    return float(gaps[edge]), edge, float(around)


def _girth(ring: Array) -> tuple[float, float]:
    """Length [m] of an outline, and how far around the middle of its flat flank at +y is."""
    lengths = np.linalg.norm(np.roll(ring, -1, axis=0) - ring, axis=1)
    start = 0.5 * lengths[-1] + np.concatenate([[0.0], np.cumsum(lengths)[:-1]])
    widest = np.isclose(ring[:, 1], ring[:, 1].max())
    return float(lengths.sum()), float(start[widest].mean())


def _side(ring: Array, edge: int) -> str:
    x, y = ring[(edge + 1) % len(ring)] - ring[edge]
    if abs(y) >= abs(x):  # the normal is (y, -x)
        return PAD if y > 0 else BACK
    return LEFT if x < 0 else RIGHT
