"""Sets of whole hands: which hand a specimen is, and the markers that were tracked on it."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from softhand_common.documents.quoted import listed, shortened
from softhand_common.documents.yaml_document import DocumentError, Node
from softhand_model.hand.hand import HandDescription, hand_names, load_hand

HAND_POSE, HAND_MOTION, PRESS, GRASP = "hand_pose", "hand_motion", "press", "grasp"
OF_HANDS = (HAND_POSE, HAND_MOTION, PRESS, GRASP)  # experiments
WITH_WRENCH = (PRESS, GRASP)
FOLLOWED = (HAND_MOTION, PRESS)  # in time, from the first sample on
MARKER_AXES = ("x", "y", "z")
MOST_SEGMENTS = 80  # of an actuator
FREE_FRAME = "free"
FRAMES = ("wrist", FREE_FRAME)  # in which places are
PRESSURE_OF, MASS_OF = "pressure.", "mass."  # before the name of a channel
FORCES, TORQUES = (tuple(f"wrench.{part}{axis}" for axis in "xyz") for part in "ft")
WRENCH_COLUMNS = (*FORCES, *TORQUES)  # at the wrist, in the axes of the world
TORQUE_ARM = 0.1  # [m] over which a torque counts as a force
LARGEST_FRICTION = 10.0  # [-] of a plate that is believed
WRIST_POSE, OBJECT_POSE = (
    tuple(f"{body}.{part}" for part in ("x", "y", "z", "qx", "qy", "qz", "qw"))
    for body in ("wrist", "object")
)
OBJECT_PLACE = OBJECT_POSE[:3]
PLACE_STIFFNESS = 100.0  # [N/m] over which a way of the object counts as a force
GAUGE_AREA = 1e-4  # [m2] over which a pressure does


@dataclass(frozen=True)
class Marker:
    """A marker on an actuator.

    at: place along the actuator, as a share of its length from the base. offset (3,) [m]: from the
    centre line there, in the frame of that line (z along it, x to the bending side).
    """

    actuator: str
    at: float = 1.0
    offset: tuple[float, ...] = (0.0, 0.0, 0.0)

    def entry(self) -> dict[str, object]:
        """Its entry in experiment.yaml, as a dictionary."""
        return {"actuator": self.actuator, "at": self.at, "offset": list(self.offset)}


@dataclass(frozen=True)
class Plate:
    """A level plate onto which a hand is pressed.

    friction [-]: coefficient between rubber and plate. height [m]: of its surface in the world.
    tared: whether the force sensor read zero at the beginning of each run, with the fingers bent.
    """

    friction: float
    height: float = 0.0
    tared: bool = False

    def entry(self) -> dict[str, object]:
        """Its entry in experiment.yaml, as a dictionary."""
        tared = {"tared": True} if self.tared else {}
        return {"friction": self.friction, "height": self.height, **tared}


@dataclass(frozen=True)
class Grasped:
    """What is grasped, and where: object and scene of the simulator, by name or file."""

    object: str
    scene: str = "table"


@dataclass(frozen=True)
class HandSpecimen:
    """A hand that was measured.

    stated: its name or file, as the set states it. description: what is read from that. segments:
    number of rigid segments of each actuator of a simulated hand; None for a real one. free_frame:
    whether positions were measured in a frame that is known from the positions alone, such as that
    of a tracked body.
    """

    stated: str
    description: HandDescription
    segments: int | None = None
    free_frame: bool = False

    @property
    def told(self) -> str:
        """Name or file of the hand, number of segments, and whether its frame is free, in words."""
        cut = f" of {self.segments} segments" if self.segments else ""
        return self.stated + cut + (" in a free frame" if self.free_frame else "")

    def entry(self) -> dict[str, object]:
        """Its keys in experiment.yaml, as a dictionary."""
        of_simulated = {} if self.segments is None else {"segments": self.segments}
        free = {"frame": FREE_FRAME} if self.free_frame else {}
        return {"hand": self.stated, **of_simulated, **free}


def read_hand(
    node: Node, folder: Path, segments: Node | None = None, frame: Node | None = None
) -> HandSpecimen:
    """Read the hand of a specimen: the name of a shipped one, or a file in the folder of the set.
    segments, frame: nodes of these keys; None if the specimen does not state them.
    """
    stated = node.text()
    try:
        found = load_hand(stated if stated in hand_names() else folder / stated)
    except ValueError as reason:
        raise DocumentError(f"{node.place}: {reason}") from reason
    cut = None if segments is None else segments.whole(1, MOST_SEGMENTS)
    return HandSpecimen(
        stated, found, cut, frame is not None and frame.choice(FRAMES) == FREE_FRAME
    )


def default_markers(hand: HandDescription) -> dict[str, Marker]:
    """One marker at each fingertip, `<tip>_tip`.

    >>> from softhand_model.hand.hand import load_hand
    >>> list(default_markers(load_hand("single_finger")))
    ['finger_tip']
    """
    first = {tip: next(iter(hand.chain(tip).actuators)) for tip in hand.tips}
    return {f"{tip}_tip": Marker(actuator) for tip, actuator in first.items()}


def read_markers(node: Node, hand: HandDescription) -> dict[str, Marker]:
    """Read the markers, by name; raises DocumentError for entries that are not valid."""
    straight = [name for chain in hand.chains if not chain.turn for name in chain.actuators]
    markers = {name: _marker(entry, straight) for name, entry in node.mapping().items()}
    if not markers:
        raise node.error("at least one marker")
    return markers


def read_plate(node: Node) -> Plate:
    """Read the plate of a press; raises DocumentError for an entry that is not valid."""
    fields = node.fields(["friction"], ["height", "tared"])
    height = fields["height"].number() if "height" in fields else 0.0
    tared = "tared" in fields and bool(fields["tared"].choice([True, False]))
    return Plate(fields["friction"].number(above=0.0, high=LARGEST_FRICTION), height, tared)


def read_grasped(object_node: Node, scene_node: Node | None) -> Grasped:
    """What is grasped; raises DocumentError naming key, expected and got."""
    usual = Grasped(object_node.text())
    return usual if scene_node is None else Grasped(usual.object, scene_node.text())


def _marker(node: Node, actuators: Sequence[str]) -> Marker:
    fields = node.fields(["actuator"], ["at", "offset"])
    return Marker(
        fields["actuator"].choice(actuators),
        fields["at"].number(low=0.0, high=1.0) if "at" in fields else 1.0,
        tuple(fields["offset"].vector()) if "offset" in fields else (0.0, 0.0, 0.0),
    )


def the_hand(hands: Mapping[str, HandSpecimen | None], place: str) -> HandDescription:
    """The hand of a set, given the hand of each specimen by name; raises DocumentError unless all
    have the same hand. place: of the specimens in the document, for the message.
    """
    stated = {name: hand.told for name, hand in hands.items() if hand is not None}
    if len(stated) < len(hands) or len(set(stated.values())) != 1:
        got = listed(f"{name}: {shortened(stated.get(name, 'none'))}" for name in hands)
        raise DocumentError(f"{place}: specimens: expected the same `hand` in all, got {got}")
    return next(hand.description for hand in hands.values() if hand is not None)


def pressure_columns(hand: HandDescription) -> tuple[str, ...]:
    """Names of the pressure columns of a hand, in the order of its channels."""
    return tuple(f"{PRESSURE_OF}{channel}" for channel in hand.channels)


def mass_columns(hand: HandDescription) -> tuple[str, ...]:
    """Names of the columns of air mass above the fill at rest, in the order of the channels."""
    return tuple(f"{MASS_OF}{channel}" for channel in hand.channels)


def marker_columns(markers: Iterable[str]) -> tuple[str, ...]:
    """Names of the columns with the positions of the markers.

    >>> marker_columns({"index_tip": Marker("index")})
    ('index_tip.x', 'index_tip.y', 'index_tip.z')
    """
    return tuple(f"{name}.{axis}" for name in markers for axis in MARKER_AXES)
