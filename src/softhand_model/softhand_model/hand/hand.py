"""Descriptions of hands: which actuators, on which channels, mounted where.

A hand is a list of chains in the frame `wrist` (z distal, x palmar, y towards the thumb of a right
hand). A chain is one actuator, a pair of straight ones side by side that bend as one, or two
parallel arcs that bend and twist as one, with or without a flexible strut at its base; it is
mounted on the wrist or on the tip of an earlier chain.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from itertools import groupby
from pathlib import Path

import numpy as np

from softhand_common.documents.quoted import listed, shortened
from softhand_common.documents.yaml_document import Bounds, Node, read_document
from softhand_common.numerics.arrays import Array
from softhand_common.numerics.rotations import from_rpy, rotate
from softhand_model.data_files import find_document, shipped_names
from softhand_model.hand import plausible
from softhand_model.hand.actuator import Actuator, actuator_names, load_actuator, own_actuators
from softhand_model.hand.palm_sheet import PalmSheet

FORMAT = "softhand-hand/1"
WRIST = "wrist"
SAME_SIDE = 0.5  # cosine of the angle between the bending sides of chains that a web may join


@dataclass(frozen=True)
class Mount:
    """Pose of a chain's base frame: position (3,) [m] and roll, pitch, yaw (3,) [rad] in the frame
    of `parent`.

    The parent is `wrist` or a chain, whose tip frame is meant.
    """

    parent: str
    position: tuple[float, ...]
    rpy: tuple[float, ...]

    @property
    def quaternion(self) -> Array:
        """Orientation as a quaternion (4,), x y z w."""
        return from_rpy(self.rpy)


@dataclass(frozen=True)
class Strut:
    """A flat polyamide strut between mount and actuator: length, width (along y), thickness (along
    x) [m].

    modulus [Pa] is Young's modulus, density [kg/m3].
    """

    length: float
    width: float
    thickness: float
    modulus: float
    density: float = 950.0

    def stiffness(self) -> Array:
        """Stiffness (3,) [N m/rad] about x, y and z of the one joint by which the whole strut is
        modelled.

        About x and y: E*I/length, as of a cantilever bent by a moment, with Young's modulus E and
        the section's second moment of area I. About z: G*J/length, with the torsion constant J =
        w*t**3/3*(1 - 0.63*t/w) of a flat strip of width w and thickness t (Roark), and the shear
        modulus G = E/2.8 (Poisson's ratio 0.4 of polyamide).

        >>> float(np.round(Strut(0.05, 0.012, 0.002, 1.7e9).stiffness()[1], 3))
        0.272
        """
        thin, wide = sorted((self.thickness, self.width))
        about_x = self.modulus * self.thickness * self.width**3 / 12.0
        about_y = self.modulus * self.width * self.thickness**3 / 12.0
        torsion = self.modulus / 2.8 * wide * thin**3 / 3.0 * (1.0 - 0.63 * thin / wide)
        return np.array([about_x, about_y, torsion]) / self.length

    @property
    def mass(self) -> float:
        """Mass [kg]."""
        return self.density * self.length * self.width * self.thickness


@dataclass(frozen=True)
class Web:
    """Mesh that joins a chain to its neighbours, from the base up to `length` [m] along its rubber.
    `chains` is the number of joined chains, including this one.

    The passive layers of the joined part are one sheet: no chain of it bends sideways (about x) or
    twists (about z) without the others, so a load on one is carried by the springs of all. That is
    exact for one loaded chain of a sheet that shears freely, and too stiff by the factor `chains`
    if all are loaded equally; bending about y is not changed. The model is ours: the thesis (7.2)
    only says that the mesh raises the low torsional stiffness.
    """

    chains: int
    length: float


@dataclass(frozen=True)
class ChainDescription:
    """One chain: its actuators (one, a pair of straight ones, or inner and outer arc) and the
    channel of each, both by name; its mount, and its strut if it has one.

    turn is +1 when the arc turns the chain's z towards its +y, -1 towards -y, and 0 for straight
    actuators. pitch [m] is the distance between the middles of a pair, the first towards -y; 0 for
    a single actuator and for arcs. web is the mesh to other chains; None if there is none.
    """

    name: str
    actuators: dict[str, Actuator] = field(hash=False)  # a dict has no hash, but is compared
    channels: dict[str, str] = field(hash=False)
    mount: Mount
    strut: Strut | None = None
    turn: int = 0
    pitch: float = 0.0
    web: Web | None = None


@dataclass(frozen=True)
class Plate:
    """The rigid wrist plate: a box of size (3,) [m] around position (3,) [m] in the wrist frame."""

    size: tuple[float, ...]
    position: tuple[float, ...]


@dataclass(frozen=True)
class HandDescription:
    """A hand: names of its channels in their order, total mass [kg], chains (parents first), names
    of the chains that have fingertips, and plate and palm sheet, None if it has none.
    """

    name: str
    channels: tuple[str, ...]
    mass: float
    chains: tuple[ChainDescription, ...]
    tips: tuple[str, ...]
    plate: Plate | None = None
    sheet: PalmSheet | None = None

    def chain(self, name: str) -> ChainDescription:
        """The chain with that name; raises ValueError if there is none."""
        for chain in self.chains:
            if chain.name == name:
                return chain
        raise ValueError(
            f"chain: expected one of {listed(chain.name for chain in self.chains)}, "
            f"got {shortened(name)}"
        )

    @property
    def actuator_names(self) -> tuple[str, ...]:
        """Names of all actuators, in the order of the chains."""
        return tuple(name for chain in self.chains for name in chain.actuators)

    def channel_of(self, actuator: str) -> int:
        """Index of the channel that feeds an actuator; raises ValueError if there is no such
        actuator.
        """
        for chain in self.chains:
            if actuator in chain.channels:
                return self.channels.index(chain.channels[actuator])
        raise ValueError(
            f"actuator: expected one of {listed(self.actuator_names)}, got {shortened(actuator)}"
        )

    def rest_volumes(self) -> Array:
        """Air volume (channels,) [m3] of chambers and tubes with all actuators straight."""
        volumes = np.zeros(len(self.channels))
        for chain in self.chains:
            for name, actuator in chain.actuators.items():
                volumes[self.channel_of(name)] += actuator.chamber_volume() + actuator.supply_volume
        return volumes

    def max_pressures(self) -> Array:
        """Pressure limit (channels,) [Pa] of every channel: that of its weakest actuator."""
        limits = np.full(len(self.channels), np.inf)
        for chain in self.chains:
            for name, actuator in chain.actuators.items():
                channel = self.channel_of(name)
                limits[channel] = min(limits[channel], actuator.max_pressure)
        return limits


def hand_names() -> list[str]:
    """Names of the shipped hands."""
    return shipped_names("hands")


def load_hand(name: str | Path) -> HandDescription:
    """A shipped hand by name, or one from a YAML file.

    Raises ValueError for a name that does not exist (the message has those that do) or a file that
    is not valid (the message has file, key, what was expected and what came).

    >>> load_hand("rbo_hand_2").channels
    ('a', 'b', 'c', 'd')
    """
    document = read_document(find_document(name, "hands", "hand"), FORMAT)
    fields = document.fields(
        ["format", "name", "channels", "mass", "chains", "tips"], ["types", "plate", "sheet"]
    )
    channels = fields["channels"].names()
    types = own_actuators(fields["types"]) if "types" in fields else {}
    if fields["chains"].mapping() == {}:
        raise fields["chains"].error("at least one chain")
    chains: dict[str, ChainDescription] = {}
    actuators: set[str] = set()
    for key, node in fields["chains"].mapping().items():
        chains[key] = _chain(key, node, channels, [WRIST, *chains], types)
        _refuse_repeated(node, actuators, chains[key])
    tips = fields["tips"].names()
    for node in fields["tips"].items():
        node.choice(chains)
    _refuse_idle_channels(fields["channels"], chains)
    _refuse_stray_webs(fields["chains"], chains)
    plate = _plate(fields["plate"]) if "plate" in fields else None
    return HandDescription(
        fields["name"].name(),
        channels,
        _mass(fields["mass"], chains),
        tuple(chains.values()),
        tips,
        plate,
        _sheet(fields["sheet"]) if "sheet" in fields else None,
    )


def _mass(node: Node, chains: dict[str, ChainDescription]) -> float:
    """Mass [kg] of the hand: at least that of its actuators and struts."""
    rubber = sum(part.mass for chain in chains.values() for part in chain.actuators.values())
    struts = sum(chain.strut.mass for chain in chains.values() if chain.strut)
    if node.within(plausible.HAND_MASS) < rubber + struts:
        raise node.error(f"at least {rubber + struts:.4g} kg, the mass of its actuators and struts")
    return node.within(plausible.HAND_MASS)


def _chain(
    name: str, node: Node, channels: tuple[str, ...], parents: list[str], types: dict[str, Actuator]
) -> ChainDescription:
    fields = node.fields(["actuators", "mount"], ["strut", "turn", "pitch", "web"])
    actuators, fed_by = {}, {}
    for key, actuator in fields["actuators"].mapping().items():
        entry = actuator.fields(["type", "channel"])
        kind = entry["type"].choice([*types, *actuator_names()])
        actuators[key] = types[kind] if kind in types else load_actuator(kind)
        fed_by[key] = entry["channel"].choice(channels)
    parts = list(actuators.values())
    _check_shape(node, fields, parts)
    arc = parts[0].arc_radius is not None
    if arc != ("turn" in fields):
        wanted = "the key turn, as its actuators are arcs"
        other = "no key turn, as its actuators are straight"
        raise node.error(wanted if arc else other, listed(fields))
    return ChainDescription(
        name,
        actuators,
        fed_by,
        _mount(fields["mount"], parents),
        _strut(fields["strut"]) if "strut" in fields else None,
        fields["turn"].choice([1, -1]) if arc else 0,
        fields["pitch"].within(_pitch_bounds(parts)) if "pitch" in fields else 0.0,
        _web(fields["web"], parts[0].length) if "web" in fields else None,
    )


def _check_shape(node: Node, fields: dict[str, Node], actuators: list[Actuator]) -> None:
    """One actuator, a pair of straight ones of one length, or two arcs of the same angle with the
    inner one first; the key pitch for a pair alone, the key web for straight ones alone.
    """
    arcs = [(actuator.arc_radius, actuator.arc_angle) for actuator in actuators]
    curved = [radius is not None for radius, _ in arcs]
    pair = curved == [False, False]
    good = len(actuators) == 1 or (pair and actuators[0].length == actuators[1].length)
    if curved == [True, True]:
        good = arcs[0][1] == arcs[1][1] and arcs[0][0] < arcs[1][0]  # type: ignore[operator]
    if not good:
        raise fields["actuators"].error(
            "one actuator, or two straight ones of one length, or two arcs of one angle, inner "
            "first",
            listed(actuator.name for actuator in actuators),
        )
    if pair != ("pitch" in fields):
        wanted = "the key pitch, as it has two straight actuators"
        other = "no key pitch, as it does not have two straight actuators"
        raise node.error(wanted if pair else other, listed(fields))
    if any(curved) and "web" in fields:
        raise fields["web"].error("no web, as its actuators are arcs")


def _pitch_bounds(parts: list[Actuator]) -> Bounds:
    """Distances [m] of the middles, from where two actuators touch at their widest."""
    x = np.append(parts[0].quadrature()[0], [0.0, parts[0].length])
    least = round(float(np.max(np.mean([part.width(x) for part in parts], axis=0))), 9)
    return Bounds(least, plausible.SECTION_SIZE.high, "m")


def _web(node: Node, most: float) -> Web:
    fields = node.fields(["chains", "length"])
    return Web(fields["chains"].choice(range(2, 11)), fields["length"].number(above=0, high=most))


def _refuse_stray_webs(node: Node, chains: dict[str, ChainDescription]) -> None:
    """Refuse a web that joins more chains than are side by side with a like web."""
    for name, chain in chains.items():
        count = _webbed_neighbours(chain, list(chains.values()))
        if chain.web is not None and count % chain.web.chains:
            web = node.mapping()[name].mapping()["web"].mapping()
            raise web["chains"].error(
                f"a divisor of {count}, the number of chains side by side that have this web"
            )


def _webbed_neighbours(chain: ChainDescription, chains: list[ChainDescription]) -> int:
    """How many chains in a row, this one counted, have a web of as many chains: on the same mount,
    bending to the same side, one after another along y of this one.
    """
    toward, along = rotate(chain.mount.quaternion, [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
    row = [
        other
        for other in chains
        if other.mount.parent == chain.mount.parent
        and toward @ rotate(other.mount.quaternion, [1.0, 0.0, 0.0]) > SAME_SIDE
    ]
    row.sort(key=lambda other: float(along @ np.array(other.mount.position)))
    runs = [list(run) for _, run in groupby(row, lambda other: other.web and other.web.chains)]
    return next(len(run) for run in runs if any(other is chain for other in run))


def _mount(node: Node, parents: list[str]) -> Mount:
    fields = node.fields(["parent", "position", "rpy"])
    return Mount(fields["parent"].choice(parents), *_pose(fields))


def _pose(fields: dict[str, Node]) -> tuple[tuple[float, ...], tuple[float, ...]]:
    """Position (3,) [m] and roll, pitch, yaw (3,) [rad]."""
    return (
        fields["position"].vector(bounds=plausible.POSITION_RANGE),
        fields["rpy"].vector(bounds=plausible.ANGLE_RANGE),
    )


def _strut(node: Node) -> Strut:
    fields = node.fields(["length", "width", "thickness", "modulus"], ["density"])
    return Strut(**{key: value.within(plausible.FLAT_PART[key]) for key, value in fields.items()})


def _plate(node: Node) -> Plate:
    fields = node.fields(["size", "position"])
    return Plate(
        fields["size"].vector(bounds=plausible.PLATE_SIZE),
        fields["position"].vector(bounds=plausible.POSITION_RANGE),
    )


def _sheet(node: Node) -> PalmSheet:
    sizes = ["length", "width", "thickness", "modulus"]
    fields = node.fields([*sizes, "angle", "position", "rpy"])
    position, rpy = _pose(fields)
    return PalmSheet(
        **{key: fields[key].within(plausible.FLAT_PART[key]) for key in sizes},
        angle=fields["angle"].number(above=0.0, high=np.pi),
        position=position,
        rpy=rpy,
    )


def _refuse_repeated(node: Node, seen: set[str], chain: ChainDescription) -> None:
    for name in chain.actuators:
        if name in seen:
            raise node.mapping()["actuators"].error(
                "names that no other chain uses", shortened(name)
            )
        seen.add(name)


def _refuse_idle_channels(node: Node, chains: dict[str, ChainDescription]) -> None:
    used = {channel for chain in chains.values() for channel in chain.channels.values()}
    for channel in node.names():
        if channel not in used:
            raise node.error("channels that feed an actuator", shortened(channel))
