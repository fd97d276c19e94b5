"""A strategy in which a hand holds poses in free air, for the lab to compare with its model."""

from __future__ import annotations

from typing import Any

import numpy as np
import yaml

from softhand_common.numerics.arrays import Array
from softhand_model.hand.hand import HandDescription

WRIST_HEIGHT = 0.5  # of the wrist above the table [m]
POSING_SPEED, POSING_TURN_SPEED = 0.3, 1.5  # of the wrist [m/s], [rad/s]
POSE_PEAK = 0.3  # highest pressure over the limit of the channel
TOGETHER_SHARES = (0.4, 0.7, 1.0)  # pressures of poses over the highest
PRESSURE_RAMP, FILL_LIMIT = 0.6, 4.0  # of a pressure, and longest time until it is reached [s]
PRESSURE_REACHED = 300.0  # error below which it is [Pa]: five steps of the sensors
POSE_HOLD = 1.4  # of a pose once it is reached [s]
ATTITUDES = {  # protocol: roll, pitch, yaw [rad] of the wrist
    "together": (0.0, 0.0, 0.0),
    "in_turn": (0.0, np.pi / 2.0, 0.0),
    "alone": (-np.pi / 2.0, 0.0, 0.0),
}
POSE_REPEATS = 2


def free_poses(hand: HandDescription, name: str) -> str:
    """Text of a strategy of the hand, which is stated as `name`: all channels together, one after
    the other, and each alone, with the wrist in another attitude each, and all of it repeated.
    """
    # the driver takes the pressure at its start for ambient: filled and emptied once, it is
    phases = _pose(hand, "filled", POSE_PEAK * hand.max_pressures())[:1]
    for repeat in range(1, POSE_REPEATS + 1):
        for protocol, rpy in ATTITUDES.items():
            phases += _run(hand, f"{protocol}_{repeat}", protocol, [float(angle) for angle in rpy])
    phases += _pose(hand, "end", np.zeros(len(hand.channels)))
    document = {
        "format": "softhand-strategy/1",
        "name": "free_poses",
        "description": "hold poses in free air, empty between them",
        "hand": name,
        "objects": ["cylinder"],
        "success": {"lift_height": 0.1, "hold_time": 1.0, "hold_phase": "end_held"},
        "phases": phases,
    }
    return yaml.safe_dump(document, sort_keys=False, width=120)


def _run(hand: HandDescription, name: str, protocol: str, rpy: list[float]) -> list[dict[str, Any]]:
    """Phases of a run: empty the hand, turn the wrist, and hold the poses of a protocol."""
    emptied, held = _pose(hand, f"{name}_empty", np.zeros(len(hand.channels)))
    turn = {
        "name": f"{name}_turn",
        "wrist": {"frame": "environment", "position": [0.0, 0.0, WRIST_HEIGHT], "rpy": rpy},
        "speed": POSING_SPEED,
        "turn_speed": POSING_TURN_SPEED,
    }
    phases = [emptied, turn, held]
    for number, shares in enumerate(pose_shares(protocol, len(hand.channels)), start=1):
        phases += _pose(hand, f"{name}_{number}", POSE_PEAK * hand.max_pressures() * shares)
    return phases


def pose_shares(protocol: str, channels: int) -> list[Array]:
    """Pressures (channels,) of each pose of a protocol, over the highest.

    >>> [shares.tolist() for shares in pose_shares("in_turn", 2)]
    [[1.0, 0.0], [1.0, 1.0]]
    """
    if protocol == "together":
        return [np.full(channels, share) for share in TOGETHER_SHARES]
    if protocol == "alone":
        return list(np.eye(channels))
    return list(np.tri(channels))


def _pose(hand: HandDescription, name: str, pressures: Array) -> list[dict[str, Any]]:
    """Phases that reach gauge pressures (channels,) [Pa], and hold them."""
    commanded = {
        channel: round(float(pressure))
        for channel, pressure in zip(hand.channels, pressures, strict=True)
    }
    reach = {
        "name": name,
        "pressure": commanded,
        "air_ramp": PRESSURE_RAMP,
        "until": {"pressure_error": {"below": PRESSURE_REACHED}},
        "time_out": FILL_LIMIT,
        "on_time_out": "next",
    }
    return [reach, {"name": f"{name}_held", "duration": POSE_HOLD}]
