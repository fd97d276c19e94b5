"""Which places the thumb's end reaches by statics: pressures and weight, no contact.

Without contact, a finger's posture depends on its own pressure alone, and the thumb's on those of
palm and thumb. So the postures on a grid of pressures are few, and every pair of them is compared.
A distance that is left is one of the hand, not of a search that missed; contact alone may change
it.
"""

from __future__ import annotations

from collections.abc import Collection
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize
from scipy.spatial.transform import Rotation

from pneuflex_sim.hand.kinematics import HandShape
from pneuflex_sim.hand.layout import build_layout
from pneuflex_sim.hand.skin_places import TIP, SkinPlaces
from softhand_model.effects.load import STANDARD_GRAVITY
from softhand_model.equilibrium.hand_statics import settled_hand
from softhand_model.hand.hand import HandDescription
from softhand_model.model_file import Model
from thesis.chapter_8.dexterity.kapandji import THUMB, THUMB_TIP, Target

Array = NDArray[np.float64]

FINGER_STEPS = 33  # pressures of a finger on the grid
THUMB_POSTURES = 5000  # of palm and thumb on the grid, at most
RING_COUNT = 5  # outlines of the thumb's end of which the distance to a place is taken
TIP_SHARE = 0.9  # where the section lies from which a tip's skin is seen as outside
APART = 0.1  # least distance of two starting points, as a share of the largest pressures
SIMPLEX = {"xatol": 1e-3, "fatol": 1e-5, "maxfev": 300}  # end of Nelder and Mead: shares, [m]


class Near(NamedTuple):
    """Distance [m] of the thumb's end from a place, and gauge pressures (channels,) [Pa]."""

    distance: float
    pressures: Array


class StaticReach:
    """Postures of an upright hand at rest, without contact.

    Args:
        hand: with a thumb on a palm.
        segments: an actuator.
        empty: names of channels that stay empty.
    """

    def __init__(self, hand: HandDescription, segments: int, empty: Collection[str] = ()) -> None:
        self._hand, self._segments = hand, segments
        self._shape = HandShape(build_layout(hand, segments, Model()))
        self._skin = SkinPlaces(self._shape)
        self._limits = hand.max_pressures() * [name not in empty for name in hand.channels]
        self._thumb = self._fed(hand.chain(THUMB).mount.parent, THUMB)
        free = int(np.count_nonzero(self._limits[self._thumb]))
        steps = int(THUMB_POSTURES ** (1.0 / free) + 1e-9)
        self._thumb_pressures = self._grid(self._thumb, steps)
        self._thumb_ends = self._ends(self.joints(self._thumb_pressures))

    def _fed(self, *chains: str) -> list[int]:
        """Channels that feed chains."""
        names = {name for chain in chains for name in self._hand.chain(chain).channels.values()}
        return [k for k, name in enumerate(self._hand.channels) if name in names]

    def _grid(self, channels: list[int], steps: int) -> Array:
        """Pressures (rows, channels) [Pa] with all combinations of some channels' steps."""
        axes = [np.unique(np.linspace(0.0, self._limits[k], steps)) for k in channels]
        combined = np.array(np.meshgrid(*axes, indexing="ij")).reshape(len(axes), -1)
        pressures = np.zeros((combined.shape[1], len(self._limits)))
        pressures[:, channels] = combined.T
        return pressures

    def joints(self, pressures: Array) -> Array:
        """Joint orientations (rows, n, 4) at gauge pressures (rows, channels) [Pa]."""
        layout = self._shape.layout
        weight = np.tile([0.0, 0.0, -STANDARD_GRAVITY], (len(pressures), 1))
        q = np.empty((len(pressures), len(layout.rest), 4))
        for body, shape in settled_hand(self._hand, Model(), self._segments, pressures.T, weight):
            base = np.broadcast_to(body.arrays.frame, (len(pressures), 1, 3, 3))
            before = np.concatenate([base, shape.frames[:, :-1]], axis=1)
            own = np.swapaxes(before, -1, -2) @ shape.frames
            turns = Rotation.from_matrix(own.reshape(-1, 3, 3)).as_quat()
            for chain, part in body.joints.items():
                q[:, layout.chain_joints[chain]] = turns.reshape(*own.shape[:2], 4)[:, part]
        return q

    def _ends(self, q: Array) -> Array:
        """Points (rows, k, 3) [m] on the skin of the thumb's end."""
        length = self._skin.length(THUMB)
        along = np.linspace(length - THUMB_TIP, length, RING_COUNT)
        return np.array([self._skin.points(THUMB, along, one) for one in q])

    def _marks(self, target: Target, q: Array) -> tuple[Array, Array]:
        """A place (rows, 3) [m] and the direction (rows, 3) out of the skin there."""
        share = TIP_SHARE if target.side == TIP else target.share
        along = [share * self._skin.length(target.finger)]
        inside = np.array([self._skin.points(target.finger, along, one).mean(axis=0) for one in q])
        marks = np.array(
            [self._skin.point(target.finger, target.share, target.side, one) for one in q]
        )
        out = marks - inside
        return marks, out / np.linalg.norm(out, axis=1, keepdims=True)

    def distance(self, target: Target, pressures: Array) -> float:
        """Distance [m] of the thumb's end from a place at pressures (channels,) [Pa], plus how far
        the middle of the thumb's end lies behind the skin there.
        """
        q = self.joints(pressures[None])
        return float(_distances(self._ends(q), *self._marks(target, q))[0, 0])

    def starts(self, target: Target, count: int) -> list[Near]:
        """Postures on the grid with the least distance (see `distance`), the nearest first, no two
        of which are alike; fingers on other channels than the target's are empty.
        """
        finger = self._fed(target.finger)
        pressures = self._grid(finger, FINGER_STEPS)
        marks, out = self._marks(target, self.joints(pressures))
        far = _distances(self._thumb_ends, marks, out)
        found: list[Near] = []
        usable = self._limits > 0.0
        for place in np.argsort(far, axis=None, kind="stable"):
            row, thumb = np.unravel_index(place, far.shape)
            both = pressures[row].copy()
            both[self._thumb] = self._thumb_pressures[thumb][self._thumb]
            changes = [(both - one.pressures)[usable] / self._limits[usable] for one in found]
            if all(np.abs(change).max() >= APART for change in changes):
                found.append(Near(float(far[row, thumb]), both))
                if len(found) == count:
                    break
        return found

    def nearest(self, target: Target) -> Near:
        """The posture of the least distance (see `distance`): the nearest on the grid, improved."""
        channels = [k for k in {*self._fed(target.finger), *self._thumb} if self._limits[k] > 0.0]

        def pressures(shares: Array) -> Array:
            full = np.zeros(len(self._limits))
            full[channels] = np.clip(shares, 0.0, 1.0) * self._limits[channels]
            return full

        start = self.starts(target, 1)[0]
        found = minimize(
            lambda shares: self.distance(target, pressures(shares)),
            start.pressures[channels] / self._limits[channels],
            method="Nelder-Mead",
            bounds=[(0.0, 1.0)] * len(channels),
            options=SIMPLEX,
        )
        return min(start, Near(float(found.fun), pressures(found.x)), key=lambda one: one.distance)


def _distances(ends: Array, marks: Array, out: Array) -> Array:
    """Distance (marks, ends) [m] of points `ends` (ends, k, 3) of the thumb from places (marks, 3),
    plus how far the middle of the points lies behind the skin, whose outward direction is `out`.
    """
    found = np.empty((len(marks), len(ends)))
    middles = ends.mean(axis=1)
    for row, (mark, normal) in enumerate(zip(marks, out, strict=True)):
        near = np.linalg.norm(ends - mark, axis=2).min(axis=1)
        found[row] = near + np.maximum(0.0, (mark - middles) @ normal)
    return found
