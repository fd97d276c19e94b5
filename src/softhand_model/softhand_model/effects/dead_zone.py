"""Pressure that does nothing until it has filled what gives way first."""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar

import numpy as np

from softhand_model.effects.effect import BENDING, NO_PRESSURE, Parameter
from softhand_model.effects.stages import Array, InputEffect, Memory


class DeadZone(InputEffect):
    """The first pressure does nothing: p -> max(0, p - threshold)."""

    name = "dead_zone"
    experiments = BENDING
    parameters = (
        Parameter(
            "threshold",
            "Pa",
            0.0,
            100e3,
            "pressure from which the actuator moves",
            typical=(500.0, 10e3),
            neutral=0.0,
        ),
    )
    unseen_in: ClassVar[Mapping[str, str]] = NO_PRESSURE
    confounded_with: ClassVar[Mapping[str, str]] = {
        "pressure_offset": "alike where no reading lies below the threshold",
        "section_rounding": "alike at low pressure, which it weakens smoothly",
    }
    rank = 3

    def chamber_pressure(self, pressure: Array, memory: Memory, dt: Array | float) -> Array:
        """Pressure [Pa] that acts."""
        return np.maximum(pressure - self.values["threshold"], 0.0)
