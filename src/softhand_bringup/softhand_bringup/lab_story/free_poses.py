"""A strategy in which a hand holds poses in free air, for the lab to compare with its model."""

from __future__ import annotations

import numpy as np

from model_lab.bench.pose_strategy import PosedRun, pose_strategy
from softhand_common.numerics.arrays import Array
from softhand_model.hand.hand import HandDescription

POSE_PEAK = 0.3  # highest pressure over the limit of the channel
TOGETHER_SHARES = (0.4, 0.7, 1.0)  # pressures of poses over the highest
ATTITUDES = {  # protocol: roll, pitch, yaw [rad] of the wrist
    "together": (0.0, 0.0, 0.0),
    "in_turn": (0.0, np.pi / 2.0, 0.0),
    "alone": (-np.pi / 2.0, 0.0, 0.0),
}
POSE_REPEATS = 2


def free_poses(hand: HandDescription, name: str) -> str:
    """Text of a strategy file for a hand, which the file calls `name`. The channels are filled all
    together, then one after the other, then each alone, with the wrist in another orientation each
    time, and all of this is repeated.
    """
    peak = POSE_PEAK * hand.max_pressures()
    runs = [
        PosedRun(
            f"{protocol}_{repeat}",
            rpy,
            [peak * shares for shares in pose_shares(protocol, len(hand.channels))],
        )
        for repeat in range(1, POSE_REPEATS + 1)
        for protocol, rpy in ATTITUDES.items()
    ]
    told = "hold poses in free air, empty between them"
    return pose_strategy(hand, name, "free_poses", told, runs)


def pose_shares(protocol: str, channels: int) -> list[Array]:
    """Pressures (channels,) [-] of each pose of a protocol, as shares of the highest pressure.

    >>> [shares.tolist() for shares in pose_shares("in_turn", 2)]
    [[1.0, 0.0], [1.0, 1.0]]
    """
    if protocol == "together":
        return [np.full(channels, share) for share in TOGETHER_SHARES]
    if protocol == "alone":
        return list(np.eye(channels))
    return list(np.tri(channels))
