"""The weight of the actuator."""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar

from softhand_model.effects.effect import Parameter
from softhand_model.effects.stages import LoadEffect

STANDARD_GRAVITY = 9.80665  # [m/s2]


class Gravity(LoadEffect):
    """The actuator's own weight, mass_scale times its mass.

    The simulator lets the physics engine pull at the segments; free bending takes the moment of
    what lies beyond x in the deformed shape, positive when it straightens (`hanging.Weight`).
    """

    name = "gravity"
    experiments = frozenset({"free_bending", "base_torque"})
    bases = frozenset({"pneuflex"})
    parameters = (
        Parameter(
            "mass_scale",
            "",
            0.0,
            10.0,
            "weight over that of the specimen's nominal mass",
            typical=(0.5, 1.5),
            neutral=0.0,
        ),
    )
    unseen_in: ClassVar[Mapping[str, str]] = {
        "blocked_tip": "a blocked finger stays straight: its weight has no lever",
        "uniaxial": "the weight of a strip is nothing against its stress",
    }
