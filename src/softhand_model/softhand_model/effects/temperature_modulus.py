"""Rubber whose modulus changes with the temperature."""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar

import numpy as np

from softhand_model.effects.effect import RUBBER, Parameter
from softhand_model.effects.stages import Array, LoadEffect

REFERENCE = 293.15  # [K] at which specimens' moduli are given


class TemperatureModulus(LoadEffect):
    """G*(1 + coefficient*(T - 293.15 K)).

    An ideal rubber has +1/293 per kelvin (its modulus is entropic); filled ones soften instead.
    """

    name = "temperature_modulus"
    experiments = RUBBER
    parameters = (
        Parameter(
            "coefficient",
            "1/K",
            -0.045,
            0.045,
            "relative change of the modulus per kelvin",
            typical=(-0.01, 0.01),
            neutral=0.0,
        ),
    )
    confounded_with: ClassVar[Mapping[str, str]] = {
        "modulus_scale": "one with it unless runs differ in temperature",
    }

    def modulus_factor(self, temperature: Array) -> Array | float:
        """Shear modulus over its value at 293.15 K, never below a hundredth."""
        return np.maximum(1.0 + self.values["coefficient"] * (temperature - REFERENCE), 0.01)
