"""Effects of the mounts and loads of a hand's fingers, and of the measurement of its markers."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from typing import ClassVar

import numpy as np

from softhand_common.numerics.arrays import Array
from softhand_model.effects.effect import Parameter
from softhand_model.effects.hand import WITH_CONTACT, WITH_MARKERS, HandEffect, turn_parameters
from softhand_model.hand.hand import HandDescription

FARTHEST_MARKER, USUAL_MARKER_OFFSET = 0.05, 0.008  # [m]
PROPERTY_FACTORS = ("", 0.05, 20.0)  # unit and bounds of a property over the nominal one
USUAL_STIFFNESS_FACTOR = (0.4, 2.5)


class StrutStiffness(HandEffect):
    """The struts that carry the fingers yield more or less: their stiffness times a factor."""

    name = "strut_stiffness"
    parameters = (
        Parameter(
            "factor",
            *PROPERTY_FACTORS,
            "stiffness of all struts over the nominal one",
            USUAL_STIFFNESS_FACTOR,
            logarithmic=True,
            neutral=1.0,
        ),
    )
    confounded_with: ClassVar[Mapping[str, str]] = {
        "mount_tilt": "alike where the hand is always held in the same way"
    }

    @classmethod
    def places(cls, hand: HandDescription, markers: Collection[str] = ()) -> list[dict[str, str]]:
        """The whole hand, if it has struts."""
        return [{}] if any(chain.strut is not None for chain in hand.chains) else []

    def strut_factor(self) -> float:
        """Factor [-] on the stiffness of all struts."""
        return float(self.values["factor"])


class PalmStiffness(HandEffect):
    """The palm yields more or less: the stiffness of its arcs and of its sheet is multiplied by a
    factor. Its free bending under pressure does not change.
    """

    name = "palm_stiffness"
    parameters = (
        Parameter(
            "factor",
            *PROPERTY_FACTORS,
            "stiffness of the palm over the nominal one",
            USUAL_STIFFNESS_FACTOR,
            logarithmic=True,
            neutral=1.0,
        ),
    )

    @classmethod
    def places(cls, hand: HandDescription, markers: Collection[str] = ()) -> list[dict[str, str]]:
        """The whole hand, if it has a palm of arcs or a sheet."""
        arcs = any(chain.turn for chain in hand.chains)
        return [{}] if arcs or hand.sheet is not None else []

    def palm_factor(self) -> float:
        """Factor [-] on the stiffness of the palm."""
        return float(self.values["factor"])


class TipMass(HandEffect):
    """A mass on a fingertip, such as a marker or a sensor, acts by its weight and its inertia."""

    name = "tip_mass"
    place_keys = ("chain",)
    parameters = (
        Parameter(
            "mass", "kg", 0.0, 0.2, "mass beyond that of the rubber", (0.002, 0.03), neutral=0.0
        ),
    )
    confounded_with: ClassVar[Mapping[str, str]] = {
        "mount_tilt": "alike where the hand is always held in the same way",
        "strut_stiffness": "alike where all fingers carry the same mass",
    }

    @classmethod
    def places(cls, hand: HandDescription, markers: Collection[str] = ()) -> list[dict[str, str]]:
        """Every fingertip."""
        return [{"chain": tip} for tip in hand.tips]

    def tip_mass_of(self, chain: str) -> float:
        """Mass [kg] at the tip of a chain."""
        return float(self.values["mass"]) if chain == self.where["chain"] else 0.0


class Friction(HandEffect):
    """The rubber of the hand has more or less friction: its Coulomb friction with other things is
    multiplied by a factor, as for dusty, wet or powdered skin. Rubber on rubber does not change.
    """

    name = "friction"
    experiments = WITH_CONTACT
    unseen_in: ClassVar[Mapping[str, str]] = dict.fromkeys(
        sorted(WITH_MARKERS), "the hand touches nothing"
    )
    parameters = (
        Parameter(
            "factor",
            *PROPERTY_FACTORS,
            "coefficients of friction of the rubber over those of the table",
            (0.5, 1.8),
            logarithmic=True,
            neutral=1.0,
        ),
    )

    @classmethod
    def places(cls, hand: HandDescription, markers: Collection[str] = ()) -> list[dict[str, str]]:
        """The whole hand."""
        return [{}]

    def friction_factor(self) -> float:
        """Factor [-] on the friction of the rubber of the hand with other things."""
        return float(self.values["factor"])


class ObjectMass(HandEffect):
    """The object that is grasped is heavier or lighter than its description says."""

    name = "object_mass"
    experiments = frozenset({"grasp"})
    unseen_in: ClassVar[Mapping[str, str]] = dict.fromkeys(
        ("hand_motion", "hand_pose", "press"), "nothing is grasped"
    )
    parameters = (
        Parameter(
            "factor",
            *PROPERTY_FACTORS,
            "mass of the object over the one described",
            (0.5, 2.0),
            logarithmic=True,
            neutral=1.0,
        ),
    )

    @classmethod
    def places(cls, hand: HandDescription, markers: Collection[str] = ()) -> list[dict[str, str]]:
        """The object."""
        return [{}]

    def object_mass_factor(self) -> float:
        """Factor [-] on the mass of the object that is grasped."""
        return float(self.values["factor"])


class MarkerOffset(HandEffect):
    """A marker is not where it is stated: it is displaced by x, y, z in the frame of the centre
    line there (z along it, x to the bending side). The simulated hand does not change with it.
    An actuator that is longer than described shows about the same as z of a marker at its tip.
    """

    name = "marker_offset"
    experiments = WITH_MARKERS
    place_keys = ("marker",)
    of_measurement = True
    parameters = tuple(
        Parameter(
            axis,
            "m",
            -FARTHEST_MARKER,
            FARTHEST_MARKER,
            f"way {where}",
            (-USUAL_MARKER_OFFSET, USUAL_MARKER_OFFSET),
            neutral=0.0,
        )
        for axis, where in (
            ("x", "to the bending side"),
            ("y", "along the bending axis"),
            ("z", "along the actuator"),
        )
    )

    @classmethod
    def places(cls, hand: HandDescription, markers: Collection[str] = ()) -> list[dict[str, str]]:
        """Every marker."""
        return [{"marker": name} for name in markers]

    def marker_offset_of(self, marker: str) -> Array:
        """Displacement (3,) [m] of a marker from its stated place, in the frame of the centre line
        there.
        """
        if marker != self.where["marker"]:
            return np.zeros(3)
        return np.array([self.values[axis] for axis in "xyz"], float)


class FrameTilt(HandEffect):
    """The frame of the markers is rotated relative to that of the wrist by roll, pitch and yaw
    about the x, y and z of the wrist. The simulated hand does not change with it.
    """

    name = "frame_tilt"
    experiments = WITH_MARKERS
    of_measurement = True
    parameters = turn_parameters("of all markers about the wrist's")

    @classmethod
    def places(cls, hand: HandDescription, markers: Collection[str] = ()) -> list[dict[str, str]]:
        """All markers at once, if there are any."""
        return [{}] if markers else []

    def frame_turn(self) -> Array:
        """Rotation of the frame of the markers relative to that of the wrist, as roll, pitch and
        yaw (3,) [rad].
        """
        return np.array([self.values[name] for name in ("roll", "pitch", "yaw")], float)
