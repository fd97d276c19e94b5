"""Frame in which the markers of a hand were tracked, relative to the wrist frame of the model."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from model_lab.aliases import Array
from model_lab.measurements.free_frame import frame_of
from model_lab.measurements.hands import Marker
from model_lab.rules import RULES
from softhand_model.chain.free_response import NoEquilibriumError
from softhand_model.effects.load import STANDARD_GRAVITY
from softhand_model.equilibrium.hand_statics import settled_hand
from softhand_model.hand.hand import HandDescription
from softhand_model.model_file import Model

MIRROR = np.array([1.0, -1.0, 1.0])
FRAME_SEGMENTS, FRAME_POSES, FRAME_LOOKS = 10, 40, 3  # of an actuator; compared; at where down is


@dataclass(frozen=True)
class WristFrame:
    """Rotation (3, 3) and translation (3,) [m] from the wrist frame of the model to the frame of
    the measured positions. of_weight: whether the direction down is known in that frame, as where
    the tracked body has it, and not in that of the wrist.
    """

    turn: Array
    shift: Array
    of_weight: bool = True

    @property
    def angle(self) -> float:
        """Angle [rad] of the rotation."""
        return float(np.arccos(np.clip((np.trace(self.turn) - 1.0) / 2.0, -1.0, 1.0)))

    @property
    def said(self) -> str:
        """Size of rotation and translation, in words."""
        far = 1e3 * float(np.linalg.norm(self.shift))
        return f"turned by {np.degrees(self.angle):.0f} deg and shifted by {far:.0f} mm"


def frame_against_wrist(
    hand: HandDescription,
    markers: Mapping[str, Marker],
    pressures: Array,
    down: Array,
    places: Mapping[str, Array],
    of_weight: bool | None = None,
) -> WristFrame | None:
    """The frame in which positions (k, 3) [m] of markers, by name, were measured, found from the
    shape of the described hand; None if it is about the wrist frame, if the shape does not tell, or
    if it is rather that of a mirrored hand.

    Motion capture measures in a frame whose origin and axes nobody has aligned with the wrist.

    pressures (channels, k) [Pa]: gauge pressures. down (k, 3): direction of the weight in the frame
    of the positions, or in that of the wrist if not `of_weight`; None: as the shape tells, that of
    the positions if both fit.
    """
    if len(places) < RULES.frame_markers:
        return None
    blown, pull, seen = _chosen(pressures, down, places)
    names = list(places)
    turn, shift = np.eye(3), np.zeros(3)
    try:
        upright = _predicted(hand, markers, names, blown, pull)
        first = _left(upright, seen, turn, shift)
        frame = WristFrame(*frame_of(upright, seen), of_weight=False)
        left = _left(upright, seen, frame.turn, frame.shift)
        mirrored = _left(upright, MIRROR * seen, *frame_of(upright, MIRROR * seen))
        for _ in range(FRAME_LOOKS if of_weight is not False else 0):
            predicted = _predicted(hand, markers, names, blown, pull @ turn)
            turn, shift = frame_of(predicted, seen)
            turned = _left(predicted, seen, turn, shift)
    except NoEquilibriumError:
        return None
    if of_weight or (of_weight is None and left > RULES.upright_gain * turned):
        frame, left = WristFrame(turn, shift), turned
    if mirrored < RULES.upright_gain * left:
        return None
    far = frame.angle > RULES.frame_turn or float(np.linalg.norm(frame.shift)) > RULES.frame_shift
    return frame if far and left <= min(RULES.frame_gain * first, RULES.frame_error) else None


def misfit(
    hand: HandDescription,
    markers: Mapping[str, Marker],
    pressures: Array,
    down: Array,
    places: Mapping[str, Array],
) -> float:
    """Root mean square distance [m] of the markers of the described hand, moved rigidly, from where
    they were seen; NaN without an equilibrium.

    pressures (channels, k) [Pa], down (k, 3) and places (k, 3) [m]: as in `frame_against_wrist`.
    """
    blown, pull, seen = _chosen(pressures, down, places)
    try:
        predicted = _predicted(hand, markers, list(places), blown, pull)
    except NoEquilibriumError:
        return float("nan")
    return _left(predicted, seen, *frame_of(predicted, seen))


def _chosen(
    pressures: Array, down: Array, places: Mapping[str, Array]
) -> tuple[Array, Array, Array]:
    """Pressures (channels, n) [Pa], weight (n, 3) [m/s2] and positions (markers n, 3) [m] of at
    most FRAME_POSES poses.
    """
    chosen = np.unique(np.linspace(0, len(down) - 1, FRAME_POSES).astype(int))
    seen = np.concatenate([place[chosen] for place in places.values()])
    return np.maximum(pressures[:, chosen], 0.0), STANDARD_GRAVITY * down[chosen], seen


def _predicted(
    hand: HandDescription,
    markers: Mapping[str, Marker],
    names: list[str],
    pressures: Array,
    pull: Array,
) -> Array:
    """Places (markers * poses, 3) [m] of the hand as described, in the frame of its wrist."""
    chain_of = {name: chain.name for chain in hand.chains for name in chain.actuators}
    found = {}
    for body, shape in settled_hand(hand, Model(), FRAME_SEGMENTS, pressures, pull):
        for name in names:
            marker = markers[name]
            if marker.actuator in body.actuators:
                offset = np.array(marker.offset)
                found[name] = body.point(shape, chain_of[marker.actuator], marker.at, offset)
    return np.concatenate([found[name] for name in names])


def _left(places: Array, seen: Array, turn: Array, shift: Array) -> float:
    """Root mean square distance [m]."""
    return float(np.sqrt(np.mean(np.sum((places @ turn.T + shift - seen) ** 2, axis=1))))
