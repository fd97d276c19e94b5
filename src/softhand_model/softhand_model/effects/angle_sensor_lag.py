"""An angle sensor that follows late."""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar

from softhand_model.effects.effect import Parameter
from softhand_model.effects.first_order import lagged
from softhand_model.effects.stages import Array, Memory, OutputEffect


class AngleSensorLag(OutputEffect):
    """The angle's reading follows the tip: time_constant*y_read' = y - y_read.

    A filter in the sensor or in the camera's tracking; exact for angles that change in a straight
    line between samples.
    """

    name = "angle_sensor_lag"
    experiments = frozenset({"free_bending"})
    quantity = "tip_angle"
    parameters = (
        Parameter(
            "time_constant",
            "s",
            1e-4,
            100.0,
            "time in which the reading follows",
            typical=(0.02, 1.0),
            logarithmic=True,
        ),
    )
    unseen_in: ClassVar[Mapping[str, str]] = dict.fromkeys(
        ("blocked_tip", "uniaxial"), "no angle is measured"
    )
    confounded_with: ClassVar[Mapping[str, str]] = {
        "tube_lag": "a lag of the input instead: where the curve is straight they are one",
        "viscoelasticity": "alike on triangles of one rate",
    }
    has_memory = True

    def reading(self, value: Array, memory: Memory, dt: Array | float) -> Array:
        """Reading [rad]."""
        return lagged(value, memory, dt, self.values["time_constant"])
