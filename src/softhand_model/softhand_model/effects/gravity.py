"""The weight of the actuator."""

from __future__ import annotations

from softhand_model.effects.effect import Parameter
from softhand_model.effects.stages import LoadEffect


class Gravity(LoadEffect):
    """The actuator's own weight, mass_scale times its mass.

    The simulator lets the physics engine pull at the segments; static experiments take the moment
    of what lies beyond x in the deformed shape, positive when it straightens.
    """

    name = "gravity"
    experiments = frozenset({"free_bending", "base_torque"})
    parameters = (
        Parameter("mass_scale", "", 0.0, 10.0, "weight over that of the specimen's nominal mass"),
    )
