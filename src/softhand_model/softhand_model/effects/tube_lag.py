"""Air that takes its time from the sensor to the chamber."""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar

from softhand_model.effects.effect import BENDING, NO_PRESSURE, Parameter
from softhand_model.effects.first_order import lagged
from softhand_model.effects.stages import Array, InputEffect, Memory


class TubeLag(InputEffect):
    """The chamber follows the sensor through the tube: time_constant*p' = p_read - p.

    First order, in place of the flow itself (`pneumatics.plant` has that); exact for readings that
    change in a straight line between samples.
    """

    name = "tube_lag"
    experiments = BENDING
    parameters = (
        Parameter(
            "time_constant",
            "s",
            1e-4,
            100.0,
            "time in which the chamber follows",
            typical=(0.02, 1.0),
            logarithmic=True,
        ),
    )
    unseen_in: ClassVar[Mapping[str, str]] = NO_PRESSURE
    confounded_with: ClassVar[Mapping[str, str]] = {
        "angle_sensor_lag": "a lag of the output instead: where the curve is straight they are one",
        "viscoelasticity": "alike on triangles of one rate",
        "hysteresis": "alike on triangles of one rate",
    }
    has_memory = True
    rank = 2

    def chamber_pressure(self, pressure: Array, memory: Memory, dt: Array | float) -> Array:
        """Pressure [Pa] in the chamber."""
        return lagged(pressure, memory, dt, self.values["time_constant"])
