"""A pressure sensor that shows too much or too little everywhere."""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar

from softhand_model.effects.effect import BENDING, NO_PRESSURE, Parameter
from softhand_model.effects.stages import Array, InputEffect, Memory


class PressureOffset(InputEffect):
    """The pressure sensor's zero is off: p_read = p + offset.

    With `pressure_gain`: p_read = gain*p + offset, so the offset is taken off first.
    """

    name = "pressure_offset"
    experiments = BENDING
    parameters = (
        Parameter(
            "offset",
            "Pa",
            -50e3,
            50e3,
            "reading at no pressure",
            typical=(-4e3, 4e3),
            neutral=0.0,
        ),
    )
    unseen_in: ClassVar[Mapping[str, str]] = NO_PRESSURE
    confounded_with: ClassVar[Mapping[str, str]] = {
        "angle_offset": "alike in free bending as far as the curve is straight",
        "force_offset": "one with it in a blocked tip as far as the force is proportional to p",
        "dead_zone": "alike where no reading lies below the threshold",
    }
    rank = 0

    def chamber_pressure(self, pressure: Array, memory: Memory, dt: Array | float) -> Array:
        """Pressure [Pa] in the chamber."""
        return pressure - self.values["offset"]
