"""Which places the thumb's end reaches by statics: pressures and weight, no contact.

Without contact, a finger's posture depends on its own pressure alone, and the thumb's on those of
palm and thumb. So the postures on a grid of pressures are few, and every pair of them is compared.
A distance that is left is one of the hand, not of a search that missed; contact alone may change
it.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize
from scipy.spatial.transform import Rotation

from pneuflex_sim.hand.kinematics import HandShape
from pneuflex_sim.hand.layout import build_layout
from pneuflex_sim.hand.skin_places import SkinPlaces
from softhand_model.effects.load import STANDARD_GRAVITY
from softhand_model.equilibrium.hand_statics import settled_hand
from softhand_model.hand.hand import HandDescription
from softhand_model.model_file import Model
from thesis.chapter_8.dexterity.kapandji import THUMB, THUMB_TIP, Target

Array = NDArray[np.float64]

FINGER_STEPS = 21  # pressures of a finger on the grid
THUMB_POSTURES = 2500  # of palm and thumb on the grid, at most
RING_COUNT = 5  # outlines of the thumb's end of which the distance to a place is taken
BALLS = 7  # within a finger, of which overlap is taken
APART = 0.1  # least distance of two starting points, as a share of the largest pressures
SIMPLEX = {"xatol": 1e-3, "fatol": 1e-5, "maxfev": 200}  # end of Nelder and Mead: shares, [m]


class Near(NamedTuple):
    """Distance [m] of the thumb's end from a place, and gauge pressures (channels,) [Pa]."""

    distance: float
    pressures: Array


class Posed(NamedTuple):
    """Positions (rows, n, 3) [m] and frames (rows, n, 3, 3) of joints in the wrist frame."""

    places: Array
    frames: Array

    def points(self, joint: int, points: Array) -> Array:
        """Points (rows, k, 3) [m] of ones (k, 3) [m] in the frame of a joint."""
        turned = np.einsum("rij,kj->rki", self.frames[:, joint], points)
        return np.asarray(self.places[:, joint, None] + turned)


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
        thumbs = self.posed(self._thumb_pressures)
        self._thumb_ends, self._thumb_balls = self._ends(thumbs), self._balls(thumbs, [THUMB])

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

    def posed(self, pressures: Array) -> Posed:
        """Joints at rest at gauge pressures (rows, channels) [Pa]."""
        layout, rows = self._shape.layout, len(pressures)
        weight = np.tile([0.0, 0.0, -STANDARD_GRAVITY], (rows, 1))
        posed = Posed(
            np.empty((rows, len(layout.rest), 3)), np.empty((rows, len(layout.rest), 3, 3))
        )
        for body, shape in settled_hand(self._hand, Model(), self._segments, pressures.T, weight):
            for chain, part in body.joints.items():
                posed.places[:, layout.chain_joints[chain]] = shape.places[:, part]
                posed.frames[:, layout.chain_joints[chain]] = shape.frames[:, part]
        return posed

    def chain_end(self, chain: str, pressures: Array) -> tuple[Array, Array]:
        """Place (rows, 3) [m] of the end of a chain that is mounted on the wrist, and by how much
        (rows,) [rad] it is twisted: the turns of its joints about its own length, in sum; at gauge
        pressures (rows, channels) [Pa].
        """
        layout, posed = self._shape.layout, self.posed(pressures)
        joints, base = layout.chain_joints[chain], self._hand.chain(chain).mount.quaternion
        before, twist = (
            Rotation.from_quat(np.tile(base, (len(pressures), 1))),
            np.zeros(len(pressures)),
        )
        for joint in range(joints.start, joints.stop):
            now = Rotation.from_matrix(posed.frames[:, joint])
            rest = Rotation.from_quat(layout.rest[joint])
            twist += (rest.inv() * before.inv() * now).as_rotvec()[:, 2]
            before = now
        return posed.points(joints.stop - 1, layout.chain_tips[chain][None])[:, 0], twist

    def _ends(self, posed: Posed) -> Array:
        """Points (rows, k, 3) [m] on the skin of the thumb's end."""
        length = self._skin.length(THUMB)
        along = np.linspace(length - THUMB_TIP, length, RING_COUNT)
        return np.concatenate(
            [posed.points(*self._skin.outline(THUMB, at)) for at in along], axis=1
        )

    def _balls(self, posed: Posed, chains: Sequence[str]) -> tuple[Array, Array]:
        """Centres (rows, k, 3) and radii (k,) [m] of balls that lie within chains."""
        centers, radii = [], []
        for chain in chains:
            for along in np.linspace(0.0, self._skin.length(chain), BALLS):
                joint, ring = self._skin.outline(chain, along)
                center = ring.mean(axis=0)
                centers.append(posed.points(joint, center[None]))
                radii.append(np.linalg.norm(ring - center, axis=1).min())
        return np.concatenate(centers, axis=1), np.array(radii)

    def _distances(
        self, target: Target, fingers: Posed, ends: Array, balls: tuple[Array, Array]
    ) -> Array:
        """Distances (rows, ends) [m], see `distance`, of fingers in some postures from thumbs with
        points `ends` (ends, k, 3) and balls.
        """
        centers, radii = self._balls(fingers, [c for c in self._skin.chains if c != THUMB])
        marks = fingers.points(*self._skin.middle(target.finger, target.share, target.side))
        both = radii[:, None] + balls[1]
        found = np.empty((len(marks), len(ends)))
        for row, (mark, own) in enumerate(zip(marks, centers, strict=True)):
            apart = np.linalg.norm(own[:, None] - balls[0][:, None], axis=-1)
            overlap = (both - apart).max(axis=(1, 2))
            found[row] = np.linalg.norm(ends - mark, axis=-1).min(axis=1) + np.maximum(overlap, 0.0)
        return found

    def distance(self, target: Target, pressures: Array) -> float:
        """Distance [m] of the thumb's end from a place at pressures (channels,) [Pa], plus how far
        the thumb lies within a finger, which contact would have to push apart.
        """
        one = self.posed(pressures[None])
        return float(self._distances(target, one, self._ends(one), self._balls(one, [THUMB]))[0, 0])

    def starts(self, target: Target, count: int) -> list[Near]:
        """Postures on the grid with the least distance (see `distance`), the nearest first, no two
        of which are alike; fingers on other channels than the target's are empty.
        """
        finger = self._fed(target.finger)
        pressures = self._grid(finger, FINGER_STEPS)
        fingers = self.posed(pressures)
        far = self._distances(target, fingers, self._thumb_ends, self._thumb_balls)
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
