"""A pressure sensor whose scale is wrong."""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar

from softhand_model.effects.effect import BENDING, NO_PRESSURE, Parameter
from softhand_model.effects.stages import Array, InputEffect, Memory


class PressureGain(InputEffect):
    """The pressure sensor's scale is off: p_read = gain*p (after `pressure_offset`).

    In bending gain and shear modulus are one: the load holds p/G. Only a gain that the calibration
    of G cannot take up shows there, or forces against a gauge.
    """

    name = "pressure_gain"
    experiments = BENDING
    parameters = (
        Parameter("gain", "", 0.2, 5.0, "reading over pressure", typical=(0.7, 1.4), neutral=1.0),
    )
    unseen_in: ClassVar[Mapping[str, str]] = NO_PRESSURE
    confounded_with: ClassVar[Mapping[str, str]] = {
        "modulus_scale": "one with the shear modulus in free bending, where only p/G acts",
        "coefficient": "one with it",
        "passive_layer_slack": "one with its ratio at small loads of a blocked tip",
    }
    rank = 1

    def chamber_pressure(self, pressure: Array, memory: Memory, dt: Array | float) -> Array:
        """Pressure [Pa] in the chamber."""
        return pressure / self.values["gain"]
