"""Text of a strategy file with which the sequencer lets a hand hold poses in free air."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import yaml

from softhand_common.numerics.arrays import Array
from softhand_model.hand.hand import HandDescription

WRIST_HEIGHT = 0.5  # of the wrist above the table [m]
POSING_SPEED, POSING_TURN_SPEED = 0.3, 1.5  # of the wrist [m/s], [rad/s]
FILL_SHARE = 0.3  # of the limit of each channel, to which all are filled before the first pose
PRESSURE_RAMP, FILL_LIMIT = 0.6, 4.0  # of a pressure, and longest time until it is reached [s]
PRESSURE_REACHED = 300.0  # error below which it is [Pa]: five steps of the sensors
POSE_HOLD = 1.4  # of a pose once it is reached [s]


@dataclass(frozen=True)
class PosedRun:
    """Poses that are held one after the other.

    wrist_rpy [rad]: roll, pitch and yaw of the wrist in the world. poses: gauge pressures
    (channels,) [Pa] of each pose.
    """

    name: str
    wrist_rpy: tuple[float, ...]
    poses: Sequence[Array]


def pose_strategy(
    hand: HandDescription, stated: str, name: str, description: str, runs: Sequence[PosedRun]
) -> str:
    """Text of the strategy file. stated: name or file of the hand. name, description: of the
    strategy. At the start of each run the hand is empty.
    """
    # the driver takes the pressure at its start for ambient: filled and emptied once, it is
    phases = _pose(hand, "filled", FILL_SHARE * hand.max_pressures())[:1]
    for run in runs:
        phases += _run(hand, run)
    phases += _pose(hand, "end", np.zeros(len(hand.channels)))
    document = {
        "format": "softhand-strategy/1",
        "name": name,
        "description": description,
        "hand": stated,
        "objects": ["cylinder"],
        "success": {"lift_height": 0.1, "hold_time": 1.0, "hold_phase": "end_held"},
        "phases": phases,
    }
    return yaml.safe_dump(document, sort_keys=False, width=120)


def _run(hand: HandDescription, run: PosedRun) -> list[dict[str, Any]]:
    """Phases of a run: empty the hand, turn the wrist, and hold the poses."""
    emptied, held = _pose(hand, f"{run.name}_empty", np.zeros(len(hand.channels)))
    turn = {
        "name": f"{run.name}_turn",
        "wrist": {
            "frame": "environment",
            "position": [0.0, 0.0, WRIST_HEIGHT],
            "rpy": [float(angle) for angle in run.wrist_rpy],
        },
        "speed": POSING_SPEED,
        "turn_speed": POSING_TURN_SPEED,
    }
    phases = [emptied, turn, held]
    for number, pressures in enumerate(run.poses, start=1):
        phases += _pose(hand, f"{run.name}_{number}", pressures)
    return phases


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
