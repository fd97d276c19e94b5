"""Effects of a whole hand. Most act at one place of it, which the lab finds along with the effect.

A class such as `ActuatorScatter` says what happens; `at` gives the class of one place, named
`actuator_scatter[index]`. For a search, each place of an effect is an effect of its own, and a
model file may hold several of them. More effects of a hand are in `hand_parts`.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping
from dataclasses import replace
from itertools import permutations
from typing import Any, ClassVar, Self

import numpy as np

from softhand_common.documents.quoted import listed, shortened
from softhand_common.numerics.arrays import Array
from softhand_common.numerics.rotations import compose, from_rpy, to_rpy
from softhand_model.effects.effect import POSED, Effect, Parameter
from softhand_model.hand.hand import HandDescription
from softhand_model.hand.joint_stiffness import DAMPING_TIME

WITH_MARKERS = frozenset({"hand_pose", "hand_motion"})
WITH_CONTACT = frozenset({"press", "grasp"})
HAND_EXPERIMENTS = WITH_MARKERS | WITH_CONTACT
LARGEST_TILT, USUAL_TILT = 0.6, 0.12  # [rad]

PLACED: dict[tuple[type[Effect], str], Any] = {}  # the classes of places, each made once


class HandEffect(Effect):
    """Base class of the effects of a hand.

    place_keys: keys that together name a place, such as `actuator`; empty for an effect of the
    whole hand. where: the place, as names by these keys; empty for a class without a place. kind:
    name of the effect without its place. of_measurement: whether the effect is one of the
    measurement, such as a displaced marker, and so does not change a simulated hand.
    """

    stage = "hand"
    experiments = HAND_EXPERIMENTS
    bases = frozenset({"pneuflex"})
    place_keys: ClassVar[tuple[str, ...]] = ()
    kind: ClassVar[str] = ""
    where: ClassVar[Mapping[str, str]] = {}
    of_measurement: ClassVar[bool] = False

    def __init_subclass__(cls) -> None:
        """Name the kind of a class that is no place of another."""
        super().__init_subclass__()
        if "name" in vars(cls) and "kind" not in vars(cls):
            cls.kind = cls.name

    @classmethod
    def at(cls, **where: str) -> type[Self]:
        """The class of the effect at one place; raises ValueError for other keys than `place_keys`.

        >>> ActuatorScatter.at(actuator="index").name
        'actuator_scatter[index]'
        """
        if set(where) != set(cls.place_keys):
            raise ValueError(
                f"effect {cls.name}: where: expected {listed(cls.place_keys)}, got {listed(where)}"
            )
        if not where:
            return cls
        names = [where[key] for key in cls.place_keys]
        name = f"{cls.name}[{'>'.join(names)}]"
        if (cls, name) not in PLACED:
            place = dict(zip(cls.place_keys, names, strict=True))
            parts = {"name": name, "kind": cls.name, "where": place, "__doc__": cls.__doc__}
            PLACED[cls, name] = type(cls.__name__, (cls,), {**parts, "__module__": __name__})
        found: type[Self] = PLACED[cls, name]
        return found

    @classmethod
    def places(cls, hand: HandDescription, markers: Collection[str] = ()) -> list[dict[str, str]]:
        """All places, as names by key, at which the effect may act in a hand with these markers."""
        raise NotImplementedError(f"{cls.__name__}.places")

    @classmethod
    def check_place(cls, hand: HandDescription, markers: Collection[str] = ()) -> None:
        """Raise ValueError unless the hand, or its markers, have the place of this class."""
        places = cls.places(hand, markers)
        if dict(cls.where) not in places:
            known = listed(" to ".join(place.values()) for place in places)
            raise ValueError(
                f"effect {cls.kind}: where: expected a place of {hand.name} ({known}), "
                f"got {shortened(' to '.join(cls.where.values()) or 'none')}"
            )

    def modulus_of(self, actuator: str) -> float:
        """Factor [-] on the shear modulus of an actuator."""
        return 1.0

    def tilt_of(self, chain: str) -> Array:
        """Rotation of the base of a chain about its own axes, as roll, pitch and yaw (3,) [rad]."""
        return np.zeros(3)

    def rest_bend_of(self, actuator: str) -> float:
        """Angle [rad] by which an actuator is bent without pressure and load."""
        return 0.0

    def share_between(self, source: str, target: str) -> float:
        """Share [-] of the pressure of channel `source` that acts in the actuators of channel
        `target`.
        """
        return 0.0

    def offset_of(self, channel: str) -> float:
        """Pressure [Pa] that the sensor of a channel reads without pressure."""
        return 0.0

    def strut_factor(self) -> float:
        """Factor [-] on the stiffness of all struts."""
        return 1.0

    def palm_factor(self) -> float:
        """Factor [-] on the stiffness of the palm: on the springs of its arcs and on its sheet."""
        return 1.0

    def tip_mass_of(self, chain: str) -> float:
        """Mass [kg] at the tip of a chain in addition to its rubber."""
        return 0.0

    def friction_factor(self) -> float:
        """Factor [-] on the friction of the rubber of the hand with other things."""
        return 1.0

    def object_mass_factor(self) -> float:
        """Factor [-] on the mass of the object that is grasped."""
        return 1.0

    def damping_time(self) -> float | None:
        """Damping of all joints over their stiffness [s]; None: as in the base model."""
        return None

    def lag_of(self, channel: str) -> float:
        """Time constant [s] with which the actuators of a channel follow its pressure."""
        return 0.0

    def marker_offset_of(self, marker: str) -> Array:
        """Displacement (3,) [m] of a marker from its stated place, in the frame of the centre line
        there.
        """
        return np.zeros(3)

    def frame_turn(self) -> Array:
        """Rotation of the frame of the markers relative to that of the wrist, as roll, pitch and
        yaw (3,) [rad].
        """
        return np.zeros(3)

    def plate_offset(self) -> float:
        """Height [m] of the plate that the hand is pressed on above the stated one."""
        return 0.0

    def wrench_gain(self) -> float:
        """Factor [-] on the measured wrench at the wrist."""
        return 1.0

    def wrench_bias(self) -> Array:
        """Force [N] and torque [N m], together (6,), that are added to the measured wrench, in the
        axes of the wrist.
        """
        return np.zeros(6)


def turn_parameters(about: str) -> tuple[Parameter, ...]:
    """Parameters roll, pitch and yaw [rad] of an effect that rotates something. about: words before
    the axis in their descriptions, as in `turn about its x`.
    """
    return tuple(
        Parameter(
            name,
            "rad",
            -LARGEST_TILT,
            LARGEST_TILT,
            f"turn {about} {axis}",
            (-USUAL_TILT, USUAL_TILT),
            neutral=0.0,
        )
        for name, axis in (("roll", "x"), ("pitch", "y"), ("yaw", "z"))
    )


class ActuatorScatter(HandEffect):
    """One actuator is softer or stiffer than the others: its shear modulus times a factor.

    It may be of silicone of another batch or age. Its channel has the same pressure, so a softer
    actuator bends more and carries less.
    """

    name = "actuator_scatter"
    place_keys = ("actuator",)
    parameters = (
        Parameter(
            "modulus_factor",
            "",
            0.2,
            5.0,
            "modulus of this actuator over the nominal one",
            (0.7, 1.4),
            logarithmic=True,
            neutral=1.0,
        ),
    )
    confounded_with: ClassVar[Mapping[str, str]] = {
        "modulus_scale": "one with it in a hand of a single actuator",
        "crosstalk": "alike where a channel feeds one actuator and the other channel goes with it",
    }

    @classmethod
    def places(cls, hand: HandDescription, markers: Collection[str] = ()) -> list[dict[str, str]]:
        """Every actuator."""
        return [{"actuator": name} for name in hand.actuator_names]

    def modulus_of(self, actuator: str) -> float:
        """Factor [-] on the shear modulus of an actuator."""
        return float(self.values["modulus_factor"]) if actuator == self.where["actuator"] else 1.0


class RestBend(HandEffect):
    """A finger is bent at rest: its whole length is curved alike without pressure and load, towards
    its bending side if the angle is positive. It may have been cast so, or stored bent, or a tendon
    or tube pulls at it.
    """

    name = "rest_bend"
    experiments = POSED
    place_keys = ("actuator",)
    parameters = (
        Parameter("angle", "rad", -1.0, 1.0, "bend without pressure", (-0.2, 0.2), neutral=0.0),
    )
    confounded_with: ClassVar[Mapping[str, str]] = {
        "mount_tilt": "pitch acts alike where only the fingertip is seen",
    }

    @classmethod
    def places(cls, hand: HandDescription, markers: Collection[str] = ()) -> list[dict[str, str]]:
        """Every actuator that is straight, as the only one of its chain."""
        straight = (c.actuators for c in hand.chains if not c.turn and len(c.actuators) == 1)
        return [{"actuator": name} for actuators in straight for name in actuators]

    def rest_bend_of(self, actuator: str) -> float:
        """Angle [rad] by which an actuator is bent without pressure and load."""
        return float(self.values["angle"]) if actuator == self.where["actuator"] else 0.0


class MountTilt(HandEffect):
    """A chain is mounted askew: its base is rotated in its mount by roll, pitch and yaw about its
    own x, y and z. Chains on its tip rotate with it.
    """

    name = "mount_tilt"
    place_keys = ("chain",)
    parameters = turn_parameters("about the chain's")
    confounded_with: ClassVar[Mapping[str, str]] = {
        "actuator_scatter": "pitch acts alike where the chain is bent alike in all poses"
    }

    @classmethod
    def places(cls, hand: HandDescription, markers: Collection[str] = ()) -> list[dict[str, str]]:
        """Every chain."""
        return [{"chain": chain.name} for chain in hand.chains]

    def tilt_of(self, chain: str) -> Array:
        """Rotation of the base of a chain about its own axes, as roll, pitch and yaw (3,) [rad]."""
        if chain != self.where["chain"]:
            return np.zeros(3)
        return np.array([self.values[name] for name in ("roll", "pitch", "yaw")], float)


class Crosstalk(HandEffect):
    """The pressure of one channel acts in another: in the actuators of `to` the gauge pressure is
    p_to + share*p_from.

    The cause may be a leak between two tubes whose pressures a regulator maintains, or a pressure
    sensor on the wrong side of such a leak. The air mass of each channel is counted without it.
    """

    name = "crosstalk"
    place_keys = ("from", "to")
    parameters = (
        Parameter(
            "share",
            "",
            0.0,
            1.0,
            "pressure that acts in `to` over that in `from`",
            (0.02, 0.3),
            neutral=0.0,
        ),
    )
    confounded_with: ClassVar[Mapping[str, str]] = {
        "actuator_scatter": "alike where both channels always have the same pressure"
    }

    @classmethod
    def places(cls, hand: HandDescription, markers: Collection[str] = ()) -> list[dict[str, str]]:
        """Every pair of channels, in both directions."""
        return [{"from": one, "to": other} for one, other in permutations(hand.channels, 2)]

    def share_between(self, source: str, target: str) -> float:
        """Share [-] of the pressure of channel `source` that acts in the actuators of channel
        `target`.
        """
        here = (source, target) == (self.where["from"], self.where["to"])
        return float(self.values["share"]) if here else 0.0


class ChannelGain(HandEffect):
    """The pressure sensor of one channel has a wrong scale: where it reads p, p/gain acts."""

    name = "channel_gain"
    experiments = POSED
    place_keys = ("channel",)
    parameters = (
        Parameter(
            "gain",
            "",
            0.2,
            5.0,
            "reading of the sensor over the pressure",
            (0.8, 1.25),
            logarithmic=True,
            neutral=1.0,
        ),
    )
    refines = ("actuator_scatter",)  # of all actuators of the channel
    confounded_with: ClassVar[Mapping[str, str]] = {
        "actuator_scatter": "nearly alike where the channel feeds one actuator"
    }

    @classmethod
    def places(cls, hand: HandDescription, markers: Collection[str] = ()) -> list[dict[str, str]]:
        """Every channel."""
        return [{"channel": name} for name in hand.channels]

    def share_between(self, source: str, target: str) -> float:
        """Share [-] of the pressure that is read in the channel by which another one acts in it."""
        here = source == target == self.where["channel"]
        return 1.0 / float(self.values["gain"]) - 1.0 if here else 0.0


class ChannelOffset(HandEffect):
    """The pressure sensor of one channel has a wrong zero: where it reads p, p - offset acts."""

    name = "channel_offset"
    experiments = POSED
    place_keys = ("channel",)
    parameters = (
        Parameter(
            "offset",
            "Pa",
            -20e3,
            20e3,
            "reading of the sensor without pressure",
            (-3e3, 3e3),
            neutral=0.0,
        ),
    )
    confounded_with: ClassVar[Mapping[str, str]] = {
        "channel_gain": "alike where the channel always has the same pressure",
        "marker_offset": "nearly alike where the channel feeds one finger",
    }

    @classmethod
    def places(cls, hand: HandDescription, markers: Collection[str] = ()) -> list[dict[str, str]]:
        """Every channel."""
        return [{"channel": name} for name in hand.channels]

    def offset_of(self, channel: str) -> float:
        """Pressure [Pa] that the sensor of a channel reads without pressure."""
        return float(self.values["offset"]) if channel == self.where["channel"] else 0.0


# ---------------------------------------------------------------------- on a hand
def effects_of_hand(effects: Iterable[Effect]) -> list[HandEffect]:
    """The effects that act on a whole hand."""
    return [effect for effect in effects if isinstance(effect, HandEffect)]


def check_places(
    hand: HandDescription, effects: Iterable[Effect], markers: Collection[str] | None = None
) -> None:
    """Raise ValueError for an effect at a place that the hand does not have, or at a marker that is
    not among `markers`; markers None: markers are not checked.
    """
    for effect in effects_of_hand(effects):
        if markers is not None or not effect.of_measurement:
            effect.check_place(hand, markers or ())


def modulus_factor(actuator: str, effects: Iterable[Effect]) -> float:
    """Factor [-] of all effects on the shear modulus of an actuator."""
    return float(np.prod([effect.modulus_of(actuator) for effect in effects_of_hand(effects)]))


def rest_bend(actuator: str, effects: Iterable[Effect]) -> float:
    """Angle [rad] by which the effects bend an actuator without pressure and load."""
    return float(sum(effect.rest_bend_of(actuator) for effect in effects_of_hand(effects)))


def palm_factor(effects: Iterable[Effect]) -> float:
    """Factor [-] of all effects on the stiffness of the palm."""
    return float(np.prod([effect.palm_factor() for effect in effects_of_hand(effects)]))


def friction_factor(effects: Iterable[Effect]) -> float:
    """Factor [-] of all effects on the friction of the rubber of the hand with other things."""
    return float(np.prod([effect.friction_factor() for effect in effects_of_hand(effects)]))


def object_mass_factor(effects: Iterable[Effect]) -> float:
    """Factor [-] on the mass of the object that is grasped, under all the effects."""
    return float(np.prod([effect.object_mass_factor() for effect in effects_of_hand(effects)]))


def damping_time(effects: Iterable[Effect]) -> float:
    """Damping of all joints over their stiffness [s]: that of an effect, or else of the
    base model.
    """
    stated = [effect.damping_time() for effect in effects_of_hand(effects)]
    return next((time for time in reversed(stated) if time is not None), DAMPING_TIME)


def channel_lags(hand: HandDescription, effects: Iterable[Effect]) -> Array:
    """Time constants (channels,) [s] with which the actuators follow the pressures of their
    channels.
    """
    acting = effects_of_hand(effects)
    return np.array([sum(e.lag_of(name) for e in acting) for name in hand.channels], float)


def tip_mass(chain: str, effects: Iterable[Effect]) -> float:
    """Mass [kg] that the effects add to the tip of a chain."""
    return float(sum(effect.tip_mass_of(chain) for effect in effects_of_hand(effects)))


def altered(hand: HandDescription, effects: Iterable[Effect]) -> HandDescription:
    """The hand with mounts, struts and palm sheet changed by the effects; raises ValueError as
    `check_places` does.
    """
    acting = effects_of_hand(effects)
    check_places(hand, acting)
    struts = float(np.prod([effect.strut_factor() for effect in acting]))
    chains = []
    for chain in hand.chains:
        turns = [tilt for effect in acting if np.any(tilt := effect.tilt_of(chain.name))]
        for tilt in turns:
            turned = to_rpy(compose(chain.mount.quaternion, from_rpy(tilt)))
            mount = replace(chain.mount, rpy=tuple(turned.tolist()))
            chain = replace(chain, mount=mount)
        if chain.strut is not None and struts != 1.0:
            strut = replace(chain.strut, modulus=struts * chain.strut.modulus)
            chain = replace(chain, strut=strut)
        chains.append(chain)
    sheet = hand.sheet
    if sheet is not None:
        sheet = replace(sheet, modulus=palm_factor(acting) * sheet.modulus)
    return replace(hand, chains=tuple(chains), sheet=sheet)


def pressure_shares(hand: HandDescription, effects: Iterable[Effect]) -> Array:
    """Share (actuators, channels) [-] of the pressure of each channel that acts in each
    actuator.
    """
    acting = effects_of_hand(effects)
    between = np.array(
        [
            [
                float(one == other) + sum(e.share_between(one, other) for e in acting)
                for one in hand.channels
            ]
            for other in hand.channels
        ]
    )
    return between[[hand.channel_of(name) for name in hand.actuator_names]]


def pressure_offsets(hand: HandDescription, effects: Iterable[Effect]) -> Array:
    """What the sensors of the channels read without pressure (channels,) [Pa], which is to be
    subtracted from pressures before their shares are taken.
    """
    acting = effects_of_hand(effects)
    return np.array([sum(e.offset_of(name) for e in acting) for name in hand.channels], float)


def at_places(
    hand: HandDescription, classes: Mapping[str, type[Effect]], markers: Collection[str] = ()
) -> dict[str, type[Effect]]:
    """Effect classes by name, in which each class without a place is replaced by one class for each
    place of the hand, or of the markers on it.
    """
    found: dict[str, type[Effect]] = {}
    for name, effect in classes.items():
        if issubclass(effect, HandEffect) and not effect.where:
            placed = [effect.at(**place) for place in effect.places(hand, markers)]
            found.update({one.name: one for one in placed})
        else:
            found[name] = effect
    return found
