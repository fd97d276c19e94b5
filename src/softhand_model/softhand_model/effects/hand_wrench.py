"""Effects of how contact was measured: by the force-torque sensor at the wrist of a hand, and on a
plate whose height is wrong. The hand does not change with them.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from typing import ClassVar

import numpy as np

from softhand_common.numerics.arrays import Array
from softhand_model.effects.effect import Parameter
from softhand_model.effects.hand import WITH_CONTACT, HandEffect
from softhand_model.hand.hand import HandDescription

FORCE_BIAS, USUAL_FORCE_BIAS = 5.0, 0.3  # [N]
TORQUE_BIAS, USUAL_TORQUE_BIAS = 0.5, 0.03  # [N m]
HIGHER, USUALLY_HIGHER = 0.010, 0.003  # [m]


class OfGauge(HandEffect):
    """Base class of the errors of the force-torque sensor at the wrist, in presses and
    grasps.
    """

    experiments = WITH_CONTACT
    of_measurement = True
    unseen_in: ClassVar[Mapping[str, str]] = dict.fromkeys(
        ("hand_motion", "hand_pose"), "no wrench is measured"
    )

    @classmethod
    def places(cls, hand: HandDescription, markers: Collection[str] = ()) -> list[dict[str, str]]:
        """The wrist."""
        return [{}]


class WrenchGain(OfGauge):
    """The force-torque sensor at the wrist has a wrong scale: it reads all forces and torques times
    the same factor. The simulated hand does not change with it.
    """

    name = "wrench_gain"
    parameters = (
        Parameter(
            "factor",
            "",
            0.2,
            5.0,
            "reading over wrench",
            (0.8, 1.25),
            logarithmic=True,
            neutral=1.0,
        ),
    )

    def wrench_gain(self) -> float:
        """Factor [-] on the measured wrench at the wrist."""
        return float(self.values["factor"])


class WrenchBias(OfGauge):
    """The force-torque sensor at the wrist has a wrong zero: the same force and torque, along the
    axes of the wrist, are added to all readings. The simulated hand does not change with it.
    """

    name = "wrench_bias"
    parameters = tuple(
        Parameter(name, unit, -most, most, f"{what} along {axis}", (-usual, usual), neutral=0.0)
        for what, unit, most, usual in (
            ("force", "N", FORCE_BIAS, USUAL_FORCE_BIAS),
            ("torque", "N m", TORQUE_BIAS, USUAL_TORQUE_BIAS),
        )
        for axis in "xyz"
        for name in (f"{what[0]}{axis}",)
    )

    def wrench_bias(self) -> Array:
        """Force [N] and torque [N m], together (6,), that are added to the measured wrench, in the
        axes of the wrist.
        """
        return np.array([self.values[parameter.name] for parameter in self.parameters], float)


class PlateHeight(HandEffect):
    """The plate that a hand is pressed on is higher or lower than stated, or the wrist lower or
    higher.
    """

    name = "plate_height"
    experiments = frozenset({"press"})
    of_measurement = True
    parameters = (
        Parameter(
            "offset",
            "m",
            -HIGHER,
            HIGHER,
            "height of the plate above the stated one",
            (-USUALLY_HIGHER, USUALLY_HIGHER),
            neutral=0.0,
        ),
    )
    confounded_with: ClassVar[Mapping[str, str]] = {
        "actuator_scatter": "alike where only this actuator touches the plate, always bent alike",
    }

    @classmethod
    def places(cls, hand: HandDescription, markers: Collection[str] = ()) -> list[dict[str, str]]:
        """The plate."""
        return [{}]

    def plate_offset(self) -> float:
        """Height [m] of the plate above the stated one."""
        return float(self.values["offset"])
