"""Load effects: changes of the load of a section, or of its shear modulus."""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar

import numpy as np

from softhand_common.numerics.arrays import Array
from softhand_model.effects.effect import (
    BENDING,
    NO_PRESSURE,
    POSED,
    RUBBER,
    Parameter,
    unseen_when_stretched,
)
from softhand_model.effects.stages import LoadEffect, SectionShape

REFERENCE = 293.15  # [K] at which specimens' moduli are given
STANDARD_GRAVITY = 9.80665  # [m/s2]


class TemperatureModulus(LoadEffect):
    """The shear modulus depends on temperature: G*(1 + coefficient*(T - 293.15 K)).

    An ideal rubber has +1/293 per kelvin (its modulus is entropic); filled rubbers soften when
    warm.
    """

    name = "temperature_modulus"
    experiments = RUBBER | POSED
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
        """Shear modulus divided by its value at 293.15 K, never below a hundredth."""
        return np.maximum(1.0 + self.values["coefficient"] * (temperature - REFERENCE), 0.01)


class SectionRounding(LoadEffect):
    """Empirical: load s*(1 - gain*exp(-max(p, 0)/pressure_scale)).

    At low pressure the section gets round instead of bending the finger. This is a guess at why the
    actuator of the thesis with a wall of 5.5 mm is stiffer at low pressure (section 5.2.2).
    """

    name = "section_rounding"
    experiments = BENDING | POSED
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
    stands_for = ("gauge_compliance",)  # of a holder that hardens force is missing likewise

    def act_on_load(self, load: Array, pressure: Array, shape: SectionShape) -> Array:
        """Load [-] that bends, at a chamber pressure [Pa], from that of the base model."""
        gone = np.exp(-np.maximum(pressure, 0.0) / self.values["pressure_scale"])
        return load * (1.0 - self.values["gain"] * gone)


class ChamberContact(LoadEffect):
    """Neighbouring chambers touch and push one another: s*(1 + gain*max(p - onset, 0)/onset).

    Empirical, for bellows and pleated actuators: swelling walls touch above a pressure, and the
    area on which they push grows in proportion to the excess.
    """

    name = "chamber_contact"
    experiments = BENDING | POSED
    parameters = (
        Parameter(
            "gain",
            "",
            0.02,
            1000.0,
            "growth of the load at twice the onset",
            (0.5, 30.0),
            logarithmic=True,
        ),
        Parameter(
            "onset",
            "Pa",
            100.0,
            5e6,
            "pressure from which chambers touch",
            (5e3, 100e3),
            logarithmic=True,
            relative=("pressure", 0.2, 0.85),
        ),
    )
    unseen_in: ClassVar[Mapping[str, str]] = NO_PRESSURE
    confounded_with: ClassVar[Mapping[str, str]] = {
        "ballooning": "alike up to where that levels off",
        "dead_zone": "alike where little bends below the onset",
        "section_rounding": "both weaken what happens at low pressure",
    }
    rank = 1

    def act_on_load(self, load: Array, pressure: Array, shape: SectionShape) -> Array:
        """Load [-] with the push between chambers, at a chamber pressure [Pa]."""
        above = np.maximum(pressure / self.values["onset"] - 1.0, 0.0)
        return load * (1.0 + self.values["gain"] * above)


class Ballooning(LoadEffect):
    """Chambers swell about a pressure: s*(1 + gain*r**n/(1 + r**n)), r = max(p, 0)/onset.

    Empirical: a thin wall yields near a pressure, as a balloon does, and stops at its neighbour or
    its fibres. The load rises from s to (1 + gain)*s about the onset, with sharpness n. It has no
    memory: walls that snap back at a lower pressure than they snapped through are not modelled.
    """

    name = "ballooning"
    experiments = BENDING | POSED
    parameters = (
        Parameter(
            "gain", "", 0.05, 200.0, "growth of the load in the end", (0.5, 12.0), logarithmic=True
        ),
        Parameter(
            "onset",
            "Pa",
            100.0,
            5e6,
            "pressure at which half of it has come",
            (5e3, 100e3),
            logarithmic=True,
            relative=("pressure", 0.45, 0.95),
        ),
        Parameter(
            "sharpness",
            "",
            3.5,
            300.0,
            "power of the pressure with which it comes",
            (6.0, 40.0),
            logarithmic=True,
        ),
    )
    unseen_in: ClassVar[Mapping[str, str]] = NO_PRESSURE
    confounded_with: ClassVar[Mapping[str, str]] = {
        "chamber_contact": "alike up to where ballooning levels off",
        "section_rounding": "both weaken what happens at low pressure",
    }

    def act_on_load(self, load: Array, pressure: Array, shape: SectionShape) -> Array:
        """Load [-] of the swollen chambers, at a chamber pressure [Pa]."""
        logarithm = np.log(np.maximum(pressure, 1e-9) / self.values["onset"])
        come = 0.5 * (1.0 + np.tanh(0.5 * self.values["sharpness"] * logarithm))
        return load * (1.0 + self.values["gain"] * come)


class Ageing(LoadEffect):
    """The rubber ages from run to run: G*(1 + per_run*n) in a specimen's n-th run, from 0.

    Runs are counted in the order of the set, for each specimen; a run with `virgin: true` counts as
    0 again. The modulus never falls below a hundredth of G. In simulator and monitor, n is 0.
    """

    name = "ageing"
    cause, member = "drift", "rubber"
    experiments = RUBBER
    axes = ("run_order",)
    fewest_runs = 2
    parameters = (
        Parameter(
            "per_run",
            "",
            -0.2,
            0.5,
            "change of the modulus from run to run over its first value",
            (-0.03, 0.03),
            neutral=0.0,
        ),
    )
    confounded_with: ClassVar[Mapping[str, str]] = {
        "modulus_scale": "one with it where each specimen has one run",
        "mullins_softening": "both soften from run to run: that one goes by the stretch",
        "temperature_modulus": "one with it if it grows warmer from run to run",
        "sensor_drift": "alike where outputs hardly differ",
    }

    def modulus_factor(self, temperature: Array) -> Array | float:
        """Shear modulus divided by that in the first run."""
        runs = np.asarray(self.around.get("run_order", 1.0)) - 1.0
        return np.maximum(1.0 + self.values["per_run"] * runs, 0.01)


class Gravity(LoadEffect):
    """The actuator's own weight, mass_scale times its mass.

    In the simulator the physics engine pulls at the segments. In free bending, the weight beyond x
    causes a moment in the deformed shape, positive when it straightens the finger
    (`loaded_finger.Weight`).
    """

    name = "gravity"
    experiments = frozenset(
        {"free_bending", "base_torque", "hand_pose", "hand_motion", "press", "grasp"}
    )
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
        "hand_motion": "the base model of hands has their weight",
        "press": "the base model of hands has their weight",
        "grasp": "the base model of hands has their weight",
        "blocked_tip": "a blocked finger stays straight: its weight has no lever",
        **unseen_when_stretched("the weight of a strip is nothing against its stress"),
    }


class TipLoad(LoadEffect):
    """Something hangs at the tip, such as a marker, a sensor or a magnet.

    On a finger that bends freely on a stand its weight W straightens or bends as the finger's own
    does (`loaded_finger.Weight`): M' = -W*sin(theta + tilt).
    """

    name = "tip_load"
    not_simulated = "nothing hangs at the tip of a simulated finger"
    experiments = frozenset({"free_bending"})
    bases = frozenset({"pneuflex"})
    parameters = (Parameter("mass", "kg", 0.0, 1.0, "mass at the tip", (2e-3, 0.05), neutral=0.0),)
    confounded_with: ClassVar[Mapping[str, str]] = {
        "gravity": "alike: a load at the tip straightens more of the finger"
    }
