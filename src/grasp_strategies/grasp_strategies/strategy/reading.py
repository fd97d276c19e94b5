"""A grasp strategy read from YAML.

The file has the keys `format: softhand-strategy/1`, `name`, `description`, `hand`, `object_rpy`
(optional), `success` (optional) and `phases`. `hand` is the name of a hand, or the path of its file
from the strategy's on. `objects` are the names of those that the strategy lifts in most trials, and
the keys of the module `tried_with` tell in which world; all are optional. A phase has a `name` and
any of

* `wrist: {frame, position, rpy, pivot}` with `speed` (greatest, [m/s]; turning `turn_speed`
  [rad/s]) or `duration` [s]. Frames: `object` (centre of the object as seen when the phase begins,
  z up, turned by its heading against `object_rpy`; axes of the world without that key),
  `environment` (the world), `wrist` (the commanded pose and its own axes), `wrist_level` (the
  commanded position with the axes of the world). Without `rpy` the orientation stays. `pivot` [m]
  is a point of the hand in the wrist's axes, its origin by default: `position` says where this
  point goes, the frames `wrist` and `wrist_level` begin at it, and it moves straight while the hand
  turns about it.
* `air_mass: {channel: kg}` above the fill at rest, and `pressure: {channel: Pa}`, gauge, each
  reached in a straight line over `air_ramp` [s]; channels that are not named keep theirs. A channel
  whose command changes from mass to pressure or back sets out from what is measured as the phase
  begins.
* `duration` [s], the least time of a phase without wrist motion.
* `until: {quantity: {above | below: value}}`: the first condition that holds ends the phase.
  Quantities: `contact_force` [N], by which the force on the wrist has changed since the phase
  began, `height` [m] of the object above its start, `air_mass_error` [kg] and `pressure_error` [Pa]
  of the channels so commanded, and gauge `pressure` [Pa], each the largest of all channels; those
  of the air count once the ramp is over. `touching: [names]` holds when all of these bodies press
  on the object. With it go `time_out` [s] and `on_time_out: error | next`. Without it a phase ends
  when motion, ramp and duration are over.
* `hold_object: {position, orientation}`: as the phase begins the object is put at this pose in the
  wrist frame, position [m] and quaternion (x, y, z, w), upright without one, and a spring holds it
  there, as an experimenter holds it out to the hand.
* `release_object`: time [s] in which that spring fades, from the beginning of the phase.
* `option`: the phase is skipped unless this option is asked for.
"""

from __future__ import annotations

import math
from pathlib import Path

from grasp_strategies.strategy.description import (
    FORMAT,
    QUANTITIES,
    Condition,
    HeldOut,
    Phase,
    Strategy,
    Success,
    Vector,
    Waypoint,
)
from grasp_strategies.strategy.tried_with import POSITION_BOUNDS, TRIED_WITH_KEYS, read_tried_with
from softhand_common.documents.quoted import listed, unknown
from softhand_common.documents.yaml_document import Bounds, Node, is_document, read_document

STRATEGY_FOLDER = Path(__file__).parents[1] / "data" / "strategies"
TAXONOMY_FOLDER = "feix"  # folder of the grasps of the Feix taxonomy, written by `thesis run feix`
WAYPOINT_FRAMES = ("object", "environment", "wrist", "wrist_level")
TOUCHING_KEY = "touching"
DEFAULT_TURN_SPEED = 1.5  # [rad/s]

_PHASE_KEYS = (
    "wrist",
    "speed",
    "turn_speed",
    "duration",
    "air_mass",
    "pressure",
    "air_ramp",
    "until",
    "time_out",
    "on_time_out",
    "hold_object",
    "release_object",
    "option",
)
# one of these a phase has to have
ACTION_KEYS = (
    "wrist",
    "air_mass",
    "pressure",
    "duration",
    "until",
    "hold_object",
    "release_object",
)

DURATION_BOUNDS = Bounds(0.0, 3600.0, "s")
ANGLE_BOUNDS = Bounds(-4.0 * math.pi, 4.0 * math.pi, "rad")
AIR_MASS_BOUNDS = Bounds(0.0, 0.1, "kg")  # 80 l
PRESSURE_BOUNDS = Bounds(0.0, 1e6, "Pa")
THRESHOLD_BOUNDS = {
    "contact_force": Bounds(-1e4, 1e4, "N"),
    "height": POSITION_BOUNDS,
    "air_mass_error": Bounds(-0.1, 0.1, "kg"),
    "pressure_error": Bounds(0.0, 1e6, "Pa"),
    "pressure": Bounds(-1e5, 1e7, "Pa"),
}
KEY_BOUNDS = {
    **dict.fromkeys(
        ("duration", "air_ramp", "time_out", "hold_time", "release_object"), DURATION_BOUNDS
    ),
    **dict.fromkeys(("lift_height", "max_slip"), Bounds(0.0, 10.0, "m")),
    "speed": Bounds(0.0, 10.0, "m/s"),
    "turn_speed": Bounds(0.0, 100.0, "rad/s"),
    "max_turn": Bounds(0.0, math.pi, "rad"),
}


def strategy_names(folder: str = "") -> list[str]:
    """Names of the strategies that come with the package: those of general use, or of a folder.

    >>> strategy_names("feix")[:2]
    ['feix/01', 'feix/02']
    """
    return sorted(
        f"{folder}/{p.stem}".strip("/") for p in (STRATEGY_FOLDER / folder).glob("*.yaml")
    )


def load_strategy(name: str | Path) -> Strategy:
    """Read a strategy by name, or by path when the name ends in .yaml.

    Raises ValueError that lists the names there are, or names file, key, what was expected and
    what came.

    >>> [phase.name for phase in load_strategy("surface_constrained").phases][:3]
    ['approach', 'touch', 'oppose']
    """
    path = Path(name)
    if path.suffix != ".yaml":
        stored = strategy_names(TAXONOMY_FOLDER)
        if str(name) not in (*strategy_names(), *stored):
            raise ValueError(
                f"strategy: expected one of {', '.join(strategy_names())}, {stored[0]} to "
                f"{stored[-1]} or the path of a .yaml file, got {unknown(name, strategy_names())}"
            )
        path = STRATEGY_FOLDER / f"{name}.yaml"
    return read_strategy(read_document(path, FORMAT))


def read_strategy(document: Node) -> Strategy:
    """The strategy of a document; raises ValueError as `load_strategy`."""
    top = document.fields(
        ("format", "name", "description", "hand", "phases"),
        ("object_rpy", "objects", "success", *TRIED_WITH_KEYS),
    )
    phases = tuple(_phase(node) for node in top["phases"].items())
    names = [phase.name for phase in phases]
    if not names or len(set(names)) < len(names):
        raise top["phases"].error("phases of different names", listed(names))
    success = _success(top["success"]) if "success" in top else Success()
    if success.hold_phase not in names:
        raise top.get("success", document).error(f"hold_phase to be one of {listed(names)}")
    return Strategy(
        top["name"].text(),
        top["description"].text(),
        _hand(top["hand"]),
        _vector(top["object_rpy"], ANGLE_BOUNDS) if "object_rpy" in top else None,
        tuple(node.text() for node in top["objects"].items()) if "objects" in top else (),
        success,
        phases,
        read_tried_with(top),
    )


def _hand(node: Node) -> str:
    """Name of a hand; a YAML file is looked for beside that of the strategy."""
    name = node.text()
    if Path(name).suffix not in (".yaml", ".yml"):
        return name
    path = Path(node.file).parent / name
    if not is_document(path):
        raise node.error(f"the name of a hand or the path of a YAML file relative to {path.parent}")
    return str(path)


def _success(node: Node) -> Success:
    fields = node.fields(optional=tuple(Success.__dataclass_fields__))
    phase = fields.pop("hold_phase", None)
    read = {key: _above_zero(child, KEY_BOUNDS[key]) for key, child in fields.items()}
    return Success(**read, hold_phase=Success.hold_phase if phase is None else phase.text())


def _phase(node: Node) -> Phase:
    fields = node.fields(("name",), _PHASE_KEYS)
    _check_timing(node, fields)
    _check_air(fields)
    conditions, touching = _until(fields["until"]) if "until" in fields else ((), frozenset())
    return Phase(
        name=fields["name"].text(),
        wrist=_waypoint(fields["wrist"]) if "wrist" in fields else None,
        speed=_positive(fields, "speed"),
        turn_speed=_positive(fields, "turn_speed") or DEFAULT_TURN_SPEED,
        duration=_positive(fields, "duration"),
        air_mass=_by_channel(fields, "air_mass", AIR_MASS_BOUNDS),
        pressure=_by_channel(fields, "pressure", PRESSURE_BOUNDS),
        air_ramp=_positive(fields, "air_ramp") or 0.0,
        until=conditions,
        until_touching=touching,
        time_out=_positive(fields, "time_out"),
        next_on_time_out="on_time_out" in fields
        and fields["on_time_out"].choice(("error", "next")) == "next",
        option=fields["option"].text() if "option" in fields else None,
        held_out=_held_out(fields["hold_object"]) if "hold_object" in fields else None,
        release=_positive(fields, "release_object"),
    )


def _held_out(node: Node) -> HeldOut:
    fields = node.fields(("position",), ("orientation",))
    if "orientation" not in fields:
        return HeldOut(_vector(fields["position"], POSITION_BOUNDS), (0.0, 0.0, 0.0, 1.0))
    x, y, z, w = fields["orientation"].vector(4)
    if not abs(math.hypot(x, y, z, w) - 1.0) < 1e-2:
        raise fields["orientation"].error("a unit quaternion x, y, z, w")
    return HeldOut(_vector(fields["position"], POSITION_BOUNDS), (x, y, z, w))


def _positive(fields: dict[str, Node], key: str) -> float | None:
    return _above_zero(fields[key], KEY_BOUNDS[key]) if key in fields else None


def _above_zero(node: Node, bounds: Bounds) -> float:
    node.positive()
    return node.within(bounds)


def _vector(node: Node, bounds: Bounds) -> Vector:
    x, y, z = node.vector(3, bounds)
    return x, y, z


def _check_timing(node: Node, fields: dict[str, Node]) -> None:
    """Raise DocumentError for a phase that could not end or whose speed is undefined."""
    if "wrist" in fields and ("speed" in fields) == ("duration" in fields):
        raise node.error("either `speed` or `duration` beside `wrist`")
    if "wrist" not in fields and "speed" in fields:
        raise fields["speed"].error("no speed in a phase without `wrist`")
    if "until" in fields and "time_out" not in fields:
        raise node.error("a `time_out` beside `until`")
    if "until" not in fields and ("time_out" in fields or "on_time_out" in fields):
        raise node.error("an `until` beside `time_out`")
    if not set(ACTION_KEYS) & fields.keys():
        raise node.error(f"at least one of {', '.join(f'`{key}`' for key in ACTION_KEYS)}")


def _check_air(fields: dict[str, Node]) -> None:
    """Raise DocumentError for a ramp without a target, and for a channel with both mass and
    pressure.
    """
    air = [fields[key] for key in ("air_mass", "pressure") if key in fields]
    if "air_ramp" in fields and not air:
        raise fields["air_ramp"].error("no ramp in a phase without `air_mass` or `pressure`")
    if len(air) == 2 and (both := air[0].mapping().keys() & air[1].mapping().keys()):
        raise air[1].error(
            f"only channels without an `air_mass`, which {listed(sorted(both))} have"
        )


def _waypoint(node: Node) -> Waypoint:
    fields = node.fields(("frame", "position"), ("rpy", "pivot"))
    return Waypoint(
        fields["frame"].choice(WAYPOINT_FRAMES),
        _vector(fields["position"], POSITION_BOUNDS),
        _vector(fields["rpy"], ANGLE_BOUNDS) if "rpy" in fields else None,
        _vector(fields["pivot"], POSITION_BOUNDS) if "pivot" in fields else (0.0, 0.0, 0.0),
    )


def _by_channel(fields: dict[str, Node], key: str, bounds: Bounds) -> dict[str, float]:
    if key not in fields:
        return {}
    return {channel: value.within(bounds) for channel, value in fields[key].mapping().items()}


def _until(node: Node) -> tuple[tuple[Condition, ...], frozenset[str]]:
    """Conditions on quantities, and the bodies that must all press on the object."""
    fields = node.fields(optional=(*QUANTITIES, TOUCHING_KEY))
    if not fields:
        raise node.error(f"at least one of {', '.join((*QUANTITIES, TOUCHING_KEY))}")
    bodies = (
        [name.text() for name in fields[TOUCHING_KEY].items()] if TOUCHING_KEY in fields else []
    )
    if TOUCHING_KEY in fields and not bodies:
        raise fields[TOUCHING_KEY].error("at least one name")
    conditions = [_condition(name, fields[name]) for name in QUANTITIES if name in fields]
    return tuple(conditions), frozenset(bodies)


def _condition(quantity: str, node: Node) -> Condition:
    bounds = node.fields(optional=("above", "below"))
    if len(bounds) != 1:
        raise node.error("either `above` or `below`")
    ((relation, value),) = bounds.items()
    return Condition(quantity, relation == "above", value.within(THRESHOLD_BOUNDS[quantity]))
