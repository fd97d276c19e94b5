"""Motions described by eleven numbers: the phases of `surface_constrained`, at a fixed place.

Motions do not depend on the object's pose: the hand moves to the reference place, and must cope
with objects beside it. With the numbers SHIPPED, over a cylinder at the reference place, the path
is that of the shipped strategy. The wrist starts so high that the ends of straight fingers are
CLEARANCE above the table, so that longer fingers do not start inside it.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import yaml

from softhand_trials.search import Variable

VARIABLES = (
    Variable("x", -0.070, 0.020),  # of the wrist before it goes down, from the reference [m]
    Variable("y", -0.090, 0.000),  # [m]
    Variable("pitch", 1.9, 2.7),  # [rad]; pi: fingers straight down
    Variable("yaw", -0.2, 1.0),  # [rad]
    Variable("touch_force", 0.5, 6.0),  # that ends the way down [N]
    Variable("air_a", 3e-5, 12e-5),  # little, ring and middle finger, above rest [kg]
    Variable("air_b", 1e-5, 4e-5),  # index
    Variable("air_c", 1e-5, 9e-5),  # thumb and inner palm
    Variable("air_d", 0.0, 8e-5),  # outer palm
    Variable("ramp", 0.3, 2.0),  # of the air [s]
    Variable("lead", -5e-5, 5e-5),  # air of thumb and palm (each) before the fingers; below 0: of a
)
SHIPPED = {
    "x": -0.026,
    "y": -0.049,
    "pitch": 2.356194490192345,
    "yaw": 0.6,
    "touch_force": 1.5,
    "air_a": 7.1e-5,
    "air_b": 2.4e-5,
    "air_c": 5.3e-5,
    "air_d": 4.3e-5,
    "ramp": 1.0,
    "lead": 3.0e-5,
}
KNUCKLES = 0.110  # from the wrist to the root of the rubber [m]: mount and strut
CLEARANCE = 0.0411  # [m]; with it the shipped motion begins where the shipped strategy does
DOWN = 0.050  # longest way down [m]
DIGITS = 9
DONE = {"air_mass_error": {"below": 4.0e-6}}


def strategy_text(values: Mapping[str, float], finger_length: float, hand: str) -> str:
    """YAML of the format softhand-strategy/1 of a motion with these numbers.

    Args:
        values: by name, as VARIABLES have them.
        finger_length: of the hand [m].
        hand: name, or path from the strategy on.
    """
    document = {
        "format": "softhand-strategy/1",
        "name": "designed_motion",
        "description": "the phases of surface_constrained with other numbers, at a fixed place",
        "hand": hand,
        "success": {"lift_height": 0.100, "hold_time": 1.0, "hold_phase": "hold", "max_slip": 0.01},
        "phases": [*_going_there(values, finger_length), *_closing(values), *_lifting()],
    }
    return yaml.safe_dump(document, sort_keys=False, default_flow_style=None)


def start_height(pitch: float, finger_length: float) -> float:
    """Height [m] of the wrist before it goes down."""
    return CLEARANCE - (KNUCKLES + finger_length) * math.cos(pitch)


def _going_there(values: Mapping[str, float], finger_length: float) -> list[dict[str, Any]]:
    height = start_height(values["pitch"], finger_length)
    return [
        {
            "name": "approach",
            "wrist": {
                "frame": "environment",
                "position": [_rounded(number) for number in (values["x"], values["y"], height)],
                "rpy": [0.0, _rounded(values["pitch"]), _rounded(values["yaw"])],
            },
            "speed": 0.4,
            "air_mass": dict.fromkeys("abcd", 0.0),
        },
        {
            "name": "touch",
            "wrist": {"frame": "wrist_level", "position": [0.0, 0.0, -DOWN]},
            "speed": 0.08,
            "until": {"contact_force": {"above": _rounded(values["touch_force"])}},
            "time_out": 3.0,
            "on_time_out": "next",
        },
    ]


def _closing(values: Mapping[str, float]) -> list[dict[str, Any]]:
    full = {channel: values[f"air_{channel}"] for channel in "abcd"}
    lead = values["lead"]
    if lead >= 0.0:
        first = {channel: min(lead, full[channel]) for channel in "cd"}
    else:
        first = {"a": min(-lead, full["a"]), "b": min(-lead / 3.0, full["b"])}
    return [_air("lead", first, values["ramp"]), _air("close", full, values["ramp"])]


def _air(name: str, masses: Mapping[str, float], ramp: float) -> dict[str, Any]:
    return {
        "name": name,
        "air_mass": {channel: _rounded(mass) for channel, mass in masses.items()},
        "air_ramp": _rounded(ramp),
        "until": DONE,
        "time_out": 4.0,
        "on_time_out": "next",
    }


def _lifting() -> list[dict[str, Any]]:
    return [
        {"name": "settle", "duration": 0.3},
        {
            "name": "lift",
            "wrist": {"frame": "wrist_level", "position": [0.0, 0.0, 0.175]},
            "speed": 0.2,
        },
        {"name": "steady", "duration": 0.3},
        {"name": "hold", "duration": 1.1},
    ]


def _rounded(value: float) -> float:
    return round(float(value), DIGITS)
