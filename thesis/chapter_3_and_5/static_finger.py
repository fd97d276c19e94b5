"""The same finger as a static chain (`thesis.chapter_3_and_5.planar`), which has no time
step.
"""

import numpy as np

from softhand_model.chain.chain import ChainModel, discretise
from softhand_model.hand.actuator import Actuator
from softhand_model.model_file import load_model
from thesis.chapter_3_and_5.planar import (
    Equilibrium,
    PlanarFinger,
    Springs,
    Stop,
    equilibrium,
    linear_springs,
    planar_finger,
)
from thesis.chapter_3_and_5.stand import FINGER, hand_of
from thesis.frame import Array


def chain_of(actuator: Actuator, segments: int) -> ChainModel:
    """The chain that the simulator makes of a weightless actuator."""
    return discretise(hand_of(actuator).chain(FINGER), segments, load_model("base"))


def blocked_finger(
    actuator: Actuator, segments: int, pressure: float, gap: float, springs: Springs | None = None
) -> Equilibrium:
    """A finger at a pressure [Pa] whose tip rests on a frictionless plane x = gap [m]; with the
    simulator's linear springs unless others are given.
    """
    model = chain_of(actuator, segments)
    if springs is None:
        rest = model.rest_rotation([pressure])[:, 1]
        springs = linear_springs(model.segments.stiffness[:, 1], rest)
    return equilibrium(planar_finger(model.segments), springs, stop=Stop((-1.0, 0.0), -gap))


def line_of(finger: PlanarFinger, angles: Array) -> Array:
    """Places (n + 2, 2) [m], x and z, of base, joints and tip.

    >>> bar = PlanarFinger(np.array([0.05]), 0.05, np.zeros(1), np.zeros((1, 2)))
    >>> line_of(bar, np.array([np.pi / 2])).round(3).tolist()
    [[0.0, 0.0], [0.0, 0.05], [0.05, 0.05]]
    """
    tangent = np.concatenate([[0.0], np.cumsum(angles)])
    along = np.append(finger.offset, finger.tip)[:, None]
    steps = along * np.stack([np.sin(tangent), np.cos(tangent)], axis=1)
    return np.vstack([np.zeros(2), np.cumsum(steps, axis=0)])
