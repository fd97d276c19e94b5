"""A designed actuator as a hand of that one finger, in the format softhand-hand/1."""

from __future__ import annotations

from typing import Any

import yaml

from softhand_model.hand.actuator import Actuator
from softhand_model.hand.hand import FORMAT, WRIST
from softhand_model.hand.profile import ConstantProfile, Profile, TableProfile, TaperedProfile

PLATE = {"size": [0.030, 0.030, 0.010], "position": [-0.010, 0.0, -0.005]}  # [m]
STAND_MASS = 0.020  # [kg]


def actuator_entry(actuator: Actuator) -> dict[str, Any]:
    """The entry of the actuator among the `types` of a hand's file, SI units."""
    sizes = ("height", "width", "circumference", "wall", "side_wall")
    profiles = {key: profile_entry(getattr(actuator, key)) for key in sizes}
    plain = ("shear_modulus", "mass", "max_pressure", "supply_volume")
    numbers = {key: float(getattr(actuator, key)) for key in plain}
    line: dict[str, Any] = {"length": actuator.length}
    if actuator.arc_radius is not None:
        line = {"arc_radius": actuator.arc_radius, "arc_angle": actuator.arc_angle}
    return {**line, **profiles, **numbers}


def finger_text(actuator: Actuator, comment: str = "") -> str:
    """Text of a YAML file of the format softhand-hand/1: the actuator as a finger on a stand, with
    lines of comment before it.
    """
    name = actuator.name
    turn = {} if actuator.arc_radius is None else {"turn": 1}
    hand = {
        "format": FORMAT,
        "name": f"{name}_on_stand",
        "channels": ["a"],
        "mass": round(actuator.mass + STAND_MASS, 3),
        "types": {name: actuator_entry(actuator)},
        "plate": PLATE,
        "chains": {
            "finger": {
                "actuators": {"finger": {"type": name, "channel": "a"}},
                "mount": {"parent": WRIST, "position": [0.0, 0.0, 0.0], "rpy": [0.0, 0.0, 0.0]},
                **turn,
            }
        },
        "tips": ["finger"],
    }
    lines = "".join(f"# {line}\n" for line in comment.splitlines())
    return lines + yaml.safe_dump(hand, sort_keys=False, default_flow_style=None)


def profile_entry(profile: Profile) -> Any:
    """A profile as plain data that `actuator.read_profile` can read."""
    if isinstance(profile, ConstantProfile):
        return profile.value
    if isinstance(profile, TableProfile):
        return [list(row) for row in zip(profile.x, profile.value, strict=True)]
    if isinstance(profile, TaperedProfile):
        return {"maximum": profile.maximum, "taper": profile.taper, "root": profile.root}
    raise ValueError(f"profile: expected a constant, a table or a taper, got {profile!r}")
