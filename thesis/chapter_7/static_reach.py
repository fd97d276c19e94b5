"""How near the end of the thumb comes to a place on a finger, over all pressures, without contact.

Chains are in equilibrium under pressures and weight, and pass through each other. A place that the
thumb stays far from here can be reached only where contact bends the fingers; a place that it comes
near to may still be shielded by other fingers.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.stats import qmc

from softhand_model.chain.chain import discretise
from softhand_model.chain.hulls import SMALLEST_EDGE
from softhand_model.chain.outline import ChainOutline, cross_section
from softhand_model.chain.segments import BEND_AXIS
from softhand_model.chain.serial import serial_chains
from softhand_model.effects import Effect
from softhand_model.effects.hand import altered, pressure_shares
from softhand_model.effects.load import STANDARD_GRAVITY
from softhand_model.equilibrium.hand_statics import HandBody, Shape
from softhand_model.gas import ROOM_TEMPERATURE
from softhand_model.hand.hand import HandDescription
from softhand_model.model_file import Model
from thesis.chapter_7.palm_cone import PALM
from thesis.chapter_8.dexterity.kapandji import THUMB, THUMB_TIP, Target
from thesis.frame import Array

SEGMENTS = 20  # an actuator, as the lab has them
ALONG, AROUND = 9, 32  # points of the skin of the thumb's end: sections, and points of each
BLOCK = 256  # rows at a time, for memory
FIRST = 2048  # pressures tried all over their range
KEPT, ROUNDS, NEARBY = 16, 7, 32  # best ones, each tried again with others nearby, round by round
SHRINKING = 0.5  # of the neighbourhood from round to round
TOO_BENT = 0.1  # [m] that each radian beyond the largest bend counts
WRONG_SIDE = 2.0  # what the depth of the thumb behind the skin of a place counts [-]


class StaticHand:
    """A hand at rest without contact, fingers up, under the base model with weight and effects.

    effects: of the hand or of its rubber; `gravity` scales the weight. limits (channels,) [Pa]: of
    the hand as described.
    """

    def __init__(self, description: HandDescription, effects: Sequence[Effect] = ()) -> None:
        self.hand = hand = altered(description, effects)
        self.limits = description.max_pressures()
        self._shares = pressure_shares(hand, effects)
        weights = [effect.values["mass_scale"] for effect in effects if effect.name == "gravity"]
        self._gravity = STANDARD_GRAVITY * float(np.prod(weights)) * np.array([0.0, 0.0, -1.0])
        model = Model(effects=tuple(effect for effect in effects if effect.name != "gravity"))
        self._bodies = {}
        for chains in serial_chains(hand):
            models = {name: discretise(hand.chain(name), SEGMENTS, model) for name in chains}
            self._bodies.update(dict.fromkeys(chains, HandBody(hand, models)))
        outline = ChainOutline(hand.chain(THUMB), SEGMENTS)
        self._ends = np.linspace(1.0 - THUMB_TIP / outline.length, 1.0, ALONG)
        unit = evenly(cross_section(), AROUND)
        self._rings = [
            outline.outlines(share * outline.length, unit, SMALLEST_EDGE)[0] for share in self._ends
        ]

    def shape(self, chain: str, pressures: Array) -> tuple[HandBody, Shape]:
        """The body of a chain, and how it rests at gauge pressures (rows, channels) [Pa]."""
        body = self._bodies[chain]
        index = [self.hand.actuator_names.index(name) for name in body.actuators]
        acting = self._shares[index] @ pressures.T
        return body, body.settle(acting, np.tile(self._gravity, (len(pressures), 1)))

    def points(self, chain: str, share: float, offsets: Array, pressures: Array) -> Array:
        """Places (rows, points, 3) [m] in the wrist frame of points at a share of a chain's length,
        with offsets (points, 3) [m] from its middle line, at gauge pressures (rows, channels) [Pa].
        """
        body, shape = self.shape(chain, pressures)
        return np.stack([body.point(shape, chain, share, offset) for offset in offsets], axis=1)

    def bends(self, pressures: Array) -> Array:
        """How far (rows, 2) [rad] palm and thumb bend over their lengths without load, at gauge
        pressures (rows, channels) [Pa].
        """
        body = self._bodies[THUMB]
        index = [self.hand.actuator_names.index(name) for name in body.actuators]
        warm = np.full(len(pressures), ROOM_TEMPERATURE)
        turns = body.free_rotations(self._shares[index] @ pressures.T, 1.0, warm)[:, :, BEND_AXIS]
        return np.stack([turns[:, body.joints[name]].sum(axis=1) for name in (PALM, THUMB)], axis=1)

    def gaps(self, target: Target, pressures: Array) -> Array:
        """Distance (rows,) [m] of the skin of the thumb's last 20 mm from a place, through the air,
        at gauge pressures (rows, channels) [Pa]. A thumb behind the skin of the place, as if it had
        come through the finger, is farther by twice its depth.
        """
        blocks = np.array_split(pressures, -(-len(pressures) // BLOCK))
        return np.concatenate([self._gaps(target, block) for block in blocks])

    def _gaps(self, target: Target, pressures: Array) -> Array:
        place, out = self._place(target, pressures)
        body, shape = self.shape(THUMB, pressures)
        found = []
        for share, ring in zip(self._ends, self._rings, strict=True):
            middle, x, y = (
                body.point(shape, THUMB, share, np.array(offset))
                for offset in ((0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0))
            )
            across = np.stack([x - middle, y - middle], axis=1)
            skin = middle[:, None] + ring @ across
            centre = skin.mean(axis=1) - place
            behind = np.minimum(np.einsum("rni,ri->rn", out, centre).max(axis=1), 0.0)
            near = np.linalg.norm(skin - place[:, None], axis=2).min(axis=1)
            found.append(near - WRONG_SIDE * behind)
        return np.min(found, axis=0)

    def _place(self, target: Target, pressures: Array) -> tuple[Array, Array]:
        """The place (rows, 3) [m], and directions (rows, n, 3) out of the skin there, in one of
        which the thumb has to be.
        """
        outline = ChainOutline(self.hand.chain(target.finger), SEGMENTS)
        height, width = outline.extents(target.share * outline.length)[0]
        offset, ways = {
            "+y": ((-0.3 * height, 0.5 * width, 0.0), [(0.0, 1.0, 0.0)]),
            "pad": ((0.0, 0.0, 0.0), [(1.0, 0.0, 0.0)]),
            "tip": ((0.0, 0.0, 0.0), [(1.0, 0.0, 0.0), (0.0, 0.0, 1.0)]),
        }[target.side]
        every = np.array([(0.0, 0.0, 0.0), offset, *ways])
        found = self.points(target.finger, target.share, every, pressures)
        return found[:, 1], found[:, 2:] - found[:, :1]


def evenly(outline: Array, count: int) -> Array:
    """A closed outline (points, 2) as `count` points at equal distances.

    >>> evenly(np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]), 8)[:3].tolist()
    [[0.0, 0.0], [0.5, 0.0], [1.0, 0.0]]
    """
    closed = np.vstack([outline, outline[:1]])
    way = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(closed, axis=0), axis=1))])
    at = np.arange(count) / count * way[-1]
    return np.stack([np.interp(at, way, closed[:, axis]) for axis in (0, 1)], axis=1)


def nearest(
    hand: StaticHand,
    target: Target,
    limits: Array | None = None,
    first: int = FIRST,
    most_bend: float = np.inf,
    rounds: int = ROUNDS,
) -> tuple[float, Array]:
    """Least distance [m] of the thumb's end from a place, and its gauge pressures (channels,) [Pa].

    Tried are `first` pressures (Sobol) from 0 to the limits (channels,) [Pa], then in some rounds
    others near the best ones. The same call gives the same answer. most_bend [rad]: of palm and of
    thumb; what bends by more than a whole turn would have to pass through itself.
    """
    limits = hand.limits if limits is None else limits

    def cost(tried: Array) -> Array:
        excess = np.maximum(hand.bends(tried) - most_bend, 0.0).sum(axis=1)
        return np.asarray(hand.gaps(target, tried) + TOO_BENT * excess)

    random = np.random.default_rng(0)
    shares = qmc.Sobol(len(limits), scramble=False).random(first)
    found = cost(shares * limits)
    for number in range(rounds):
        best = np.argsort(found)[:KEPT]
        shares, found = shares[best], found[best]
        wide = 0.25 * SHRINKING**number
        step = random.uniform(-wide, wide, (len(shares), NEARBY, len(limits)))
        more = np.clip(shares[:, None] + step, 0.0, 1.0).reshape(-1, len(limits))
        shares = np.vstack([shares, more])
        found = np.concatenate([found, cost(more * limits)])
    best = int(np.argmin(found))
    return float(found[best]), shares[best] * limits
