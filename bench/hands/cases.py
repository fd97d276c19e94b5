"""What is hidden in a hand: where it can be said otherwise, not by the lab's classes of effects.

The plan, its seeds and its criteria were fixed before anything was run. Strong and weak effects of
each kind at places drawn by the seed, hands without anything, three things outside of the catalogue
(a channel that saturates, a marker that sags, a wrist that yields), and negative controls.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from itertools import permutations
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from bench.hands.slips import SLIPS
from model_lab.measurements.hands import MARKER_AXES
from model_lab.measurements.measurement_set import MeasurementSet, Run
from softhand_common.numerics.arrays import Array
from softhand_model.effects import effect_classes
from softhand_model.effects.hand import RestBend
from softhand_model.effects.hand_motion import ChannelLag, JointDamping
from softhand_model.effects.hand_parts import TipMass
from softhand_model.hand.hand import ChainDescription, HandDescription
from softhand_model.model_file import Model

SEED = 3300  # of the first case; the others follow
SIZES = {  # (strong, weak)
    "actuator_scatter": (0.72, 0.90),  # modulus over the nominal one, or one over that
    "mount_tilt": (0.10, 0.04),  # [rad] about an axis that is drawn
    "crosstalk": (0.20, 0.06),  # share of the pressure
    "strut_stiffness": (0.35, 0.75),
    "palm_stiffness": (0.45, 0.80),
    "tip_mass": (0.020, 0.006),  # [kg]
    "marker_offset": (0.006, 0.002),  # [m] in a direction that is drawn
    "frame_tilt": (0.06, 0.02),  # [rad] about an axis that is drawn
    "dead_zone": (4e3, 1.5e3),  # [Pa]
    "yeoh_stiffening": (0.30, 0.12),  # its c2
}
SENSOR_SIZES = {  # (strong, weak), apart, as they change no drawn seed
    "channel_gain": (1.20, 1.07),  # reading over the pressure, or one over that
    "channel_offset": (2.0e3, 0.8e3),  # [Pa] read without pressure, or the negative
}
LATER_SIZES = {  # the same
    "rest_bend": (0.15, 0.05),  # [rad], or the negative
    "gravity": (1.4, 1.15),  # weight over the stated one
}
SENSOR = "channel_gain and channel_offset"  # of one channel
FIRST_KINDS = ("actuator_scatter", "mount_tilt", "crosstalk")
OUTSIDE = {
    "limited_channel": 0.5,  # of the highest pressure, beyond which a drawn channel does not rise
    "loose_marker": 0.006,  # [m] by which a drawn marker sags
    "soft_wrist": 0.06,  # [rad] by which the hand sags when it is held level
}
ONE_VALUE = (
    "crosstalk",
    "strut_stiffness",
    "palm_stiffness",
    "tip_mass",
    "dead_zone",
    "yeoh_stiffening",
    "channel_gain",
    "channel_offset",
    "rest_bend",
    "gravity",
    "joint_damping",
    "channel_lag",
)
CONTROLS = ("markers_shuffled", "pressures_shuffled", "another_hand")
TWO = (  # strong ones
    ("actuator_scatter", "crosstalk"),
    ("mount_tilt", "actuator_scatter"),
    ("mount_tilt", "crosstalk"),
    ("actuator_scatter", "dead_zone"),
    ("strut_stiffness", "tip_mass"),
    ("palm_stiffness", "marker_offset"),
    ("yeoh_stiffening", "mount_tilt"),
)
PLAN = [
    *[(kind, strength) for kind in FIRST_KINDS for strength in ["strong"] * 3 + ["weak"] * 3],
    *[("nothing", "")] * 4,
    *[(kind, size) for kind in [*SIZES][len(FIRST_KINDS) :] for size in ("strong", "weak")],
    *[(name, "outside") for name in OUTSIDE] * 2,
    *[(name, "control") for name in CONTROLS],
    *[("nothing", "")] * 2,
    # later, before any of these was run
    *[(" and ".join(names), "two") for names in TWO],
    *[(name, "slip") for name in SLIPS],
    # later still, before any of these was run
    *[(kind, size) for kind in SENSOR_SIZES for size in ("strong", "weak")],
    *[(SENSOR, "two")] * 2,
    # after case 63: channel_offset is searched from the beginning; before these were run
    ("channel_offset", "strong"),
    ("channel_offset", "weak"),
    *[(kind, size) for kind in LATER_SIZES for size in ("strong", "weak")],
    # after case 65: a finer form is also tried with an effect of its place; before these were run
    *[(SENSOR, "two")] * 3,
]
HIGHEST = (26e3, 26e3, 30e3, 45e3)  # [Pa] of the channels
OTHER_PLACES, OTHER_STRUTS = 0.9, 0.8  # of another hand, over those of the stated one


def _same(pressures: Array) -> Array:
    return pressures


def _as_they_are(places: Array, frames: Array, down: Array) -> Array:
    return places


@dataclass(frozen=True)
class Hidden:
    """A hand with something hidden: its description, model, what pressures (channels,) [Pa] act in
    place of those that are read, what sensors read (poses, channels) of pressures that act, where
    fingertips are seen that are at places (tips, 3) [m] with frames (tips, 3, 3) while (3,) is
    down, and the truth as a verdict would have it; value: of its only parameter, if it has one;
    both: names and places of two effects; slip: its name and column, if there is one.
    """

    hand: HandDescription
    name: str
    strength: str
    where: dict[str, str] = field(default_factory=dict)
    effects: tuple[Any, ...] = ()
    acting: Callable[[Array], Array] = _same
    read: Callable[[Array], Array] = _same
    seen: Callable[[Array, Array, Array], Array] = _as_they_are
    value: float | None = None
    both: tuple[tuple[str, dict[str, str]], ...] = ()
    slip: tuple[str, str] | None = None

    @property
    def model(self) -> Model:
        """The model of the simulated hand, with its weight."""
        weight = self.value if self.name == "gravity" else 1.0
        return Model(effects=(effect_classes()["gravity"](mass_scale=weight), *self.effects))


def hidden_in(
    hand: HandDescription,
    kind: str,
    strength: str,
    random: np.random.Generator,
    share: float | None = None,
    sizes: Mapping[str, tuple[float, float]] = SIZES,
) -> Hidden:
    """A case of the plan; share: of the way from the strong size to the weak one."""
    sizes = {**sizes, **SENSOR_SIZES, **LATER_SIZES}
    if kind == SENSOR:
        return _of_a_sensor(hand, random)
    if strength == "two":
        first, second = kind.split(" and ")
        one = hidden_in(hand, first, "strong", random, share, sizes)
        return _both(one, hidden_in(one.hand, second, "strong", random, share, sizes))
    size = OUTSIDE.get(kind, 0.0)
    if kind in sizes:
        strong, weak = sizes[kind]
        way = float(strength == "weak") if share is None else share
        size = strong ** (1.0 - way) * weak**way
    plain = Hidden(hand, kind, strength, value=size if kind in ONE_VALUE else None)
    classes = effect_classes()
    if kind == "actuator_scatter":
        name = str(random.choice(hand.actuator_names))
        factor = float(size if random.uniform() < 0.5 else 1.0 / size)
        softer = _softened(hand, name, factor)
        return replace(plain, hand=softer, where={"actuator": name}, value=factor)
    if kind == "mount_tilt":
        name = str(random.choice([chain.name for chain in hand.chains]))
        turn = _drawn_way(size, random)
        return replace(plain, hand=_turned(hand, name, turn), where={"chain": name})
    if kind == "crosstalk":
        pairs = list(permutations(range(len(hand.channels)), 2))
        source, target = pairs[random.integers(len(pairs))]

        def leaking(pressures: Array) -> Array:
            more = pressures.copy()
            more[target] += size * pressures[source]
            return more

        names = hand.channels
        return replace(plain, where={"from": names[source], "to": names[target]}, acting=leaking)
    if kind == "strut_stiffness":
        return replace(plain, hand=_each(hand, lambda chain: _with_strut(chain, size)))
    if kind == "palm_stiffness":
        return replace(plain, effects=(classes[kind](factor=size),))
    if kind == "tip_mass":
        name = str(random.choice(hand.tips))
        effect = TipMass.at(chain=name)(mass=size)
        return replace(plain, effects=(effect,), where={"chain": name})
    if kind in ("marker_offset", "loose_marker"):
        tip = int(random.integers(len(hand.tips)))
        mine = (np.arange(len(hand.tips)) == tip)[:, None]
        if kind == "loose_marker":
            return replace(plain, seen=lambda at, frames, down: at + mine * size * down)
        way = _drawn_way(size, random)
        return replace(
            plain,
            where={"marker": f"{hand.tips[tip]}_tip"},
            seen=lambda at, frames, down: at + mine * (frames @ way),
        )
    if kind == "frame_tilt":
        frame = Rotation.from_rotvec(_drawn_way(size, random)).as_matrix()
        return replace(plain, seen=lambda at, frames, down: at @ frame)
    if kind == "soft_wrist":
        return replace(plain, seen=lambda at, frames, down: _sagging(at, size, down))
    if kind == "dead_zone":
        return replace(plain, acting=lambda pressures: np.maximum(pressures - size, 0.0))
    if kind == "yeoh_stiffening":
        return replace(plain, effects=(classes[kind](c2=size),))
    if kind == "joint_damping":
        return replace(plain, effects=(JointDamping(time=size),))
    if kind == "channel_lag":
        name = str(random.choice(hand.channels))
        lag = ChannelLag.at(channel=name)(time_constant=size)
        return replace(plain, effects=(lag,), where={"channel": name})
    if kind == "rest_bend":
        name = str(random.choice(hand.tips))
        angle = float(size if random.uniform() < 0.5 else -size)
        effect = RestBend.at(actuator=name)(angle=angle)
        return replace(plain, effects=(effect,), where={"actuator": name}, value=angle)
    if kind in SENSOR_SIZES:
        channel = int(random.integers(len(hand.channels)))
        gains, offsets = np.ones(len(hand.channels)), np.zeros(len(hand.channels))
        larger = random.uniform() < 0.5
        if kind == "channel_gain":
            value = gains[channel] = size if larger else 1.0 / size
        else:
            value = offsets[channel] = size if larger else -size
        where = {"channel": hand.channels[channel]}
        return replace(plain, where=where, value=float(value), read=lambda p: gains * p + offsets)
    if kind == "limited_channel":
        limit = np.full(len(hand.channels), np.inf)
        channel = int(random.integers(len(limit)))
        limit[channel] = size * HIGHEST[channel]
        return replace(plain, acting=lambda pressures: np.minimum(pressures, limit))
    if kind == "another_hand":
        return replace(plain, hand=_each(hand, _of_another_hand))
    return plain


def _of_a_sensor(hand: HandDescription, random: np.random.Generator) -> Hidden:
    """The sensor of a drawn channel with a wrong scale and a wrong zero, both strong."""
    name = str(random.choice(hand.channels))
    here = np.array([one == name for one in hand.channels])
    gain, offset = (strong for strong, _ in SENSOR_SIZES.values())
    kinds = tuple((kind, {"channel": name}) for kind in SENSOR_SIZES)
    return Hidden(
        hand,
        SENSOR,
        "two",
        {"channel": name},
        read=lambda pressures: np.where(here, gain * pressures + offset, pressures),
        both=kinds,
    )


def _both(one: Hidden, other: Hidden) -> Hidden:
    """Two effects in one hand, of which the second was hidden in the hand of the first."""
    return Hidden(
        other.hand,
        f"{one.name} and {other.name}",
        "two",
        {**one.where, **other.where},
        one.effects + other.effects,
        acting=lambda pressures: other.acting(one.acting(pressures)),
        seen=lambda at, frames, down: other.seen(one.seen(at, frames, down), frames, down),
        both=((one.name, one.where), (other.name, other.where)),
    )


def _drawn_way(size: float, random: np.random.Generator) -> Array:
    """A vector (3,) of a size in a direction that is drawn."""
    way = random.standard_normal(3)
    return np.asarray(size * way / np.linalg.norm(way))


def _sagging(places: Array, angle: float, down: Array) -> Array:
    """Places (tips, 3) [m] of a hand whose wrist yields to its weight."""
    along = np.array([0.0, 0.0, 1.0])
    return places @ Rotation.from_rotvec(angle * np.cross(along, down)).as_matrix().T


def shuffled(data: MeasurementSet, kind: str, random: np.random.Generator) -> MeasurementSet:
    """A set with its markers exchanged in an order drawn for every sample, or with the pressures of
    each run those of another one; as it is for any other kind.
    """
    runs = list(data.runs)
    if kind == "markers_shuffled":
        runs = [_with_markers_shuffled(run, [*data.markers], random) for run in runs]
    if kind == "pressures_shuffled":
        order = random.permutation(len(runs))
        others = [runs[index].columns for index in order.tolist()]
        runs = [
            replace(run, columns={**run.columns, **{key: other[key] for key in data.inputs}})
            for run, other in zip(runs, others, strict=True)
        ]
    return replace(data, runs=tuple(runs))


def _with_markers_shuffled(run: Run, markers: list[str], random: np.random.Generator) -> Run:
    orders = [random.permutation(len(markers)) for _ in range(run.samples)]
    columns = dict(run.columns)
    for axis in MARKER_AXES:
        table = np.array([run.columns[f"{marker}.{axis}"] for marker in markers])
        mixed = np.stack([table[order, at] for at, order in enumerate(orders)], axis=1)
        columns |= {f"{marker}.{axis}": row for marker, row in zip(markers, mixed, strict=True)}
    return replace(run, columns=columns)


def _each(
    hand: HandDescription, change: Callable[[ChainDescription], ChainDescription]
) -> HandDescription:
    return replace(hand, chains=tuple(change(chain) for chain in hand.chains))


def _softened(hand: HandDescription, actuator: str, factor: float) -> HandDescription:
    def change(chain: ChainDescription) -> ChainDescription:
        parts = {
            name: part.with_modulus(factor) if name == actuator else part
            for name, part in chain.actuators.items()
        }
        return replace(chain, actuators=parts)

    return _each(hand, change)


def _turned(hand: HandDescription, name: str, turn: Array) -> HandDescription:
    def change(chain: ChainDescription) -> ChainDescription:
        if chain.name != name:
            return chain
        mount = Rotation.from_euler("xyz", chain.mount.rpy) * Rotation.from_rotvec(turn)
        return replace(chain, mount=replace(chain.mount, rpy=tuple(mount.as_euler("xyz").tolist())))

    return _each(hand, change)


def _with_strut(chain: ChainDescription, factor: float) -> ChainDescription:
    if chain.strut is None:
        return chain
    return replace(chain, strut=replace(chain.strut, modulus=factor * chain.strut.modulus))


def _of_another_hand(chain: ChainDescription) -> ChainDescription:
    place = tuple(OTHER_PLACES * along for along in chain.mount.position)
    moved = replace(chain, mount=replace(chain.mount, position=place))
    return _with_strut(moved, OTHER_STRUTS)
