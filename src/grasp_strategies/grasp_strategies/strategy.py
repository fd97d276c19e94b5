"""A grasp strategy as data: phases of wrist motion and air, read from YAML.

The file has the keys `format: softhand-strategy/1`, `name`, `description`, `hand`, `object_rpy`
(optional), `objects` (optional: names of objects that it lifts, as trials have shown), `success`
(optional) and `phases`. `hand` is the name of a hand, or the path of its file from the strategy's
on. A phase has a `name` and any of

* `wrist: {frame, position, rpy}` with `speed` (greatest, [m/s]; turning `turn_speed` [rad/s]) or
  `duration` [s]. Frames: `object` (centre of the object as seen when the phase begins, z up, turned
  by its heading against `object_rpy`; axes of the world without that key), `environment` (the
  world), `wrist` (the commanded pose and its own axes), `wrist_level` (the commanded position with
  the axes of the world). Without `rpy` the orientation stays.
* `air_mass: {channel: kg}` above the fill at rest, reached in a straight line over `air_ramp` [s];
  channels that are not named keep theirs.
* `duration` [s], the least time of a phase without wrist motion.
* `until: {quantity: {above | below: value}}`: the first condition that holds ends the phase.
  Quantities: `contact_force` [N] on the wrist, `height` [m] of the object above its start,
  `air_mass_error` [kg] and gauge `pressure` [Pa], the largest of all channels. With it go
  `time_out` [s] and `on_time_out: error | next`. Without it a phase ends when motion, ramp and
  duration are over.
* `option`: the phase is skipped unless this option is asked for.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path

from softhand_model.documents.quoted import listed, quoted
from softhand_model.documents.yaml_document import Bounds, Node, is_document, read_document

FORMAT = "softhand-strategy/1"
DATA = Path(__file__).with_name("data") / "strategies"
FRAMES = ("object", "environment", "wrist", "wrist_level")
QUANTITIES = {"contact_force": "N", "height": "m", "air_mass_error": "kg", "pressure": "Pa"}
DEFAULT_TURN_SPEED = 1.5  # [rad/s]

_PHASE_KEYS = (
    "wrist",
    "speed",
    "turn_speed",
    "duration",
    "air_mass",
    "air_ramp",
    "until",
    "time_out",
    "on_time_out",
    "option",
)

LONGEST = Bounds(0.0, 3600.0, "s")
PLACE = Bounds(-10.0, 10.0, "m")
ANGLE = Bounds(-4.0 * math.pi, 4.0 * math.pi, "rad")
AIR_MASS = Bounds(0.0, 0.1, "kg")  # 80 l
THRESHOLDS = {
    "contact_force": Bounds(-1e4, 1e4, "N"),
    "height": PLACE,
    "air_mass_error": Bounds(-0.1, 0.1, "kg"),
    "pressure": Bounds(-1e5, 1e7, "Pa"),
}
BOUNDS = {
    **dict.fromkeys(("duration", "air_ramp", "time_out", "hold_time"), LONGEST),
    **dict.fromkeys(("lift_height", "max_slip"), Bounds(0.0, 10.0, "m")),
    "speed": Bounds(0.0, 10.0, "m/s"),
    "turn_speed": Bounds(0.0, 100.0, "rad/s"),
    "max_turn": Bounds(0.0, math.pi, "rad"),
}

Vector = tuple[float, float, float]


@dataclass(frozen=True)
class Waypoint:
    """Where the wrist goes: `position` [m] and `rpy` [rad], None to keep it, in a frame."""

    frame: str
    position: Vector
    rpy: Vector | None


@dataclass(frozen=True)
class Condition:
    """An end condition: a quantity above or below a threshold in the quantity's unit."""

    quantity: str
    above: bool
    threshold: float

    def holds(self, value: float) -> bool:
        """Whether a value of the quantity fulfils the condition.

        >>> Condition("contact_force", above=True, threshold=2.0).holds(2.5)
        True
        """
        return value > self.threshold if self.above else value < self.threshold

    def __str__(self) -> str:
        relation = "above" if self.above else "below"
        return f"{self.quantity} {relation} {self.threshold:g} {QUANTITIES[self.quantity]}"


@dataclass(frozen=True)
class Phase:
    """One phase: times [s], speeds [m/s] and [rad/s], air masses [kg]; see the module's text."""

    name: str
    wrist: Waypoint | None
    speed: float | None
    turn_speed: float
    duration: float | None
    air_mass: dict[str, float]
    air_ramp: float
    until: tuple[Condition, ...]
    time_out: float | None
    next_on_time_out: bool
    option: str | None


@dataclass(frozen=True)
class Success:
    """When a grasp counts: least lift [m] and hold [s], the phase to judge, largest slip [m] and
    largest turn [rad] of the object in the hand.
    """

    lift_height: float = 0.100
    hold_time: float = 1.0
    hold_phase: str = "hold"
    max_slip: float = 0.010
    max_turn: float = math.radians(20.0)


@dataclass(frozen=True)
class Strategy:
    """A strategy: its name, what it is for, the hand it was written for (by name, or by the path of
    its file), the objects that it is known to lift, and its phases in order.
    """

    name: str
    description: str
    hand: str
    object_rpy: Vector | None
    objects: tuple[str, ...]
    success: Success
    phases: tuple[Phase, ...]

    @property
    def options(self) -> frozenset[str]:
        """Names of the options that switch phases on."""
        return frozenset(phase.option for phase in self.phases if phase.option)


def strategy_names() -> list[str]:
    """Names of the strategies that come with the package."""
    return sorted(path.stem for path in DATA.glob("*.yaml"))


def load_strategy(name: str | Path) -> Strategy:
    """Read a strategy by name, or by path when the name ends in .yaml.

    Raises ValueError that lists the names there are, or names file, key, what was expected and
    what came.

    >>> [phase.name for phase in load_strategy("surface_constrained").phases][:3]
    ['approach', 'touch', 'close']
    """
    path = Path(name)
    if path.suffix != ".yaml":
        if str(name) not in strategy_names():
            raise ValueError(
                f"strategy: expected one of {', '.join(strategy_names())} or the path of a "
                f".yaml file, got {quoted(str(name))}"
            )
        path = DATA / f"{name}.yaml"
    return _strategy(read_document(path, FORMAT))


def _strategy(document: Node) -> Strategy:
    top = document.fields(
        ("format", "name", "description", "hand", "phases"), ("object_rpy", "objects", "success")
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
        _vector(top["object_rpy"], ANGLE) if "object_rpy" in top else None,
        tuple(node.text() for node in top["objects"].items()) if "objects" in top else (),
        success,
        phases,
    )


def _hand(node: Node) -> str:
    """Name of a hand; a YAML file is looked for beside that of the strategy."""
    name = node.text()
    if Path(name).suffix not in (".yaml", ".yml"):
        return name
    path = Path(node.file).parent / name
    if not is_document(path):
        raise node.error(f"the name of a hand or the path of a YAML file from {path.parent} on")
    return str(path)


def _success(node: Node) -> Success:
    fields = node.fields(optional=tuple(Success.__dataclass_fields__))
    read = {
        key: child.text() if key == "hold_phase" else _above_zero(child, BOUNDS[key])
        for key, child in fields.items()
    }
    return Success(**read)


def _phase(node: Node) -> Phase:
    fields = node.fields(("name",), _PHASE_KEYS)
    _check_timing(node, fields)
    return Phase(
        name=fields["name"].text(),
        wrist=_waypoint(fields["wrist"]) if "wrist" in fields else None,
        speed=_positive(fields, "speed"),
        turn_speed=_positive(fields, "turn_speed") or DEFAULT_TURN_SPEED,
        duration=_positive(fields, "duration"),
        air_mass=_air_mass(fields["air_mass"]) if "air_mass" in fields else {},
        air_ramp=_positive(fields, "air_ramp") or 0.0,
        until=_conditions(fields["until"]) if "until" in fields else (),
        time_out=_positive(fields, "time_out"),
        next_on_time_out="on_time_out" in fields
        and fields["on_time_out"].choice(("error", "next")) == "next",
        option=fields["option"].text() if "option" in fields else None,
    )


def _positive(fields: dict[str, Node], key: str) -> float | None:
    return _above_zero(fields[key], BOUNDS[key]) if key in fields else None


def _above_zero(node: Node, bounds: Bounds) -> float:
    node.positive()
    return node.within(bounds)


def _vector(node: Node, bounds: Bounds) -> Vector:
    x, y, z = node.vector(3, bounds)
    return x, y, z


def _check_timing(node: Node, fields: dict[str, Node]) -> None:
    """Refuse phases that could not end or whose speed is not defined."""
    if "wrist" in fields and ("speed" in fields) == ("duration" in fields):
        raise node.error("either `speed` or `duration` beside `wrist`")
    if "wrist" not in fields and "speed" in fields:
        raise fields["speed"].error("no speed in a phase without `wrist`")
    if "air_ramp" in fields and "air_mass" not in fields:
        raise fields["air_ramp"].error("no ramp in a phase without `air_mass`")
    if "until" in fields and "time_out" not in fields:
        raise node.error("a `time_out` beside `until`")
    if "until" not in fields and ("time_out" in fields or "on_time_out" in fields):
        raise node.error("an `until` beside `time_out`")
    if not {"wrist", "air_mass", "duration", "until"} & fields.keys():
        raise node.error("at least one of `wrist`, `air_mass`, `duration`, `until`")


def _waypoint(node: Node) -> Waypoint:
    fields = node.fields(("frame", "position"), ("rpy",))
    return Waypoint(
        fields["frame"].choice(FRAMES),
        _vector(fields["position"], PLACE),
        _vector(fields["rpy"], ANGLE) if "rpy" in fields else None,
    )


def _air_mass(node: Node) -> dict[str, float]:
    return {channel: mass.within(AIR_MASS) for channel, mass in node.mapping().items()}


def _conditions(node: Node) -> tuple[Condition, ...]:
    fields = node.fields(optional=QUANTITIES)
    if not fields:
        raise node.error(f"at least one of {', '.join(QUANTITIES)}")
    return tuple(_condition(quantity, bound) for quantity, bound in fields.items())


def _condition(quantity: str, node: Node) -> Condition:
    bounds = node.fields(optional=("above", "below"))
    if len(bounds) != 1:
        raise node.error("either `above` or `below`")
    ((relation, value),) = bounds.items()
    return Condition(quantity, relation == "above", value.within(THRESHOLDS[quantity]))
