"""Load effects: what changes the load or the modulus."""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar

import numpy as np

from softhand_model.effects.effect import (
    BENDING,
    NO_PRESSURE,
    RUBBER,
    Parameter,
    unseen_when_stretched,
)
from softhand_model.effects.stages import LoadEffect, SectionShape
from softhand_model.numerics.arrays import Array

REFERENCE = 293.15  # [K] at which specimens' moduli are given
STANDARD_GRAVITY = 9.80665  # [m/s2]


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
            (-0.01, 0.01),
            neutral=0.0,
        ),
    )
    confounded_with: ClassVar[Mapping[str, str]] = {
        "modulus_scale": "one with it unless runs differ in temperature"
    }

    def modulus_factor(self, temperature: Array) -> Array | float:
        """Shear modulus over its value at 293.15 K, never below a hundredth."""
        return np.maximum(1.0 + self.values["coefficient"] * (temperature - REFERENCE), 0.01)


class SectionRounding(LoadEffect):
    """Empirical: load s*(1 - gain*exp(-max(p, 0)/pressure_scale)).

    At low pressure the section rounds instead of bending the finger. One guess at why the thesis's
    actuator with a wall of 5.5 mm is stiffer at low pressure; it leaves the cause open (section
    5.2.2).
    """

    name = "section_rounding"
    experiments = BENDING
    parameters = (
        Parameter(
            "gain",
            "",
            0.0,
            0.99,
            "share of the load that is lost at no pressure",
            (0.05, 0.6),
            neutral=0.0,
        ),
        Parameter(
            "pressure_scale",
            "Pa",
            100.0,
            1e6,
            "pressure over which the section becomes round",
            (3e3, 40e3),
            logarithmic=True,
        ),
    )
    unseen_in: ClassVar[Mapping[str, str]] = NO_PRESSURE
    confounded_with: ClassVar[Mapping[str, str]] = {
        "dead_zone": "alike at low pressure",
        "thick_wall": "alike on one wall thickness: specimens of several tell them apart",
        "actuation_nonlinearity": "alike on one wall thickness",
    }

    def act_on_load(self, load: Array, pressure: Array, shape: SectionShape) -> Array:
        """Load [-] that bends at a chamber pressure [Pa]."""
        gone = np.exp(-np.maximum(pressure, 0.0) / self.values["pressure_scale"])
        return load * (1.0 - self.values["gain"] * gone)


class Gravity(LoadEffect):
    """The actuator's own weight, mass_scale times its mass.

    The simulator lets the physics engine pull at the segments; free bending takes the moment of
    what lies beyond x in the deformed shape, positive when it straightens (`loaded_finger.Weight`).
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
            (0.5, 1.5),
            neutral=0.0,
        ),
    )
    unseen_in: ClassVar[Mapping[str, str]] = {
        "blocked_tip": "a blocked finger stays straight: its weight has no lever",
        **unseen_when_stretched("the weight of a strip is nothing against its stress"),
    }
