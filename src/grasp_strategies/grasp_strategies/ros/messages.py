"""Contents of ROS messages as checked arrays. The readers accept any object with the right fields,
so tests need no ROS.

Every reader raises ValueError naming the field, what was expected and what came; such a message is
refused as a whole.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from grasp_strategies.pose import Pose
from grasp_strategies.ros.marker_bytes import MarkerBytes
from grasp_strategies.ros.stamped_bytes import StampedBytes
from grasp_strategies.scene import Array
from softhand_ros.diagnostics import PREPARING, cut
from softhand_ros.topics import seconds

WORLD = "world"
OBJECT = "object"
SAFETY_SUFFIX = ": safety"  # how the name of the driver's report ends that tells whether it works
CONTROL_MODES_KEY = "control modes"  # key under which the driver reports them
LEVEL_OK, LEVEL_ERROR = b"\x00", b"\x02"  # levels of diagnostic_msgs/DiagnosticStatus
SAME_STAMP_TOLERANCE = 1e-6  # by which the stamps of one instant may differ [s]
# by which state may be stamped ahead of the scene's time; beyond, by another clock [s]
MAX_STATE_LEAD = 0.1
MARKER_ADD = 0  # visualization_msgs/Marker.ADD; others delete


@dataclass(frozen=True)
class AirState:
    """State of the Pneumaticbox: channels, air mass [kg above rest], gauge pressure [Pa]."""

    channels: tuple[str, ...]
    air_mass: Array
    pressure: Array


def _finite(field: str, values: Sequence[float], count: int) -> Array:
    if len(values) != count or not all(map(math.isfinite, values)):
        raise ValueError(f"{field}: expected {count} finite numbers, got {list(values)}")
    return np.array(values, float)


def read_pose(message: Any) -> Pose:
    """Pose in `world` from the bytes of a geometry_msgs/PoseStamped."""
    if message.frame != WORLD:
        raise ValueError(f"header.frame_id: expected {WORLD}, got {message.frame!r}")
    position = _finite("pose.position", message.numbers[:3], 3)
    orientation = _finite("pose.orientation", message.numbers[3:], 4)
    norm = float(np.linalg.norm(orientation))
    if abs(norm - 1.0) > 1e-2:
        raise ValueError(
            f"pose.orientation: expected a unit quaternion, got one of length {norm:.3g}"
        )
    return Pose(position, orientation / norm)


def read_force(message: Any) -> Array:
    """Force (3,) [N] from the bytes of a geometry_msgs/WrenchStamped."""
    return _finite("wrench.force", message.numbers[:3], 3)


def read_air_state(message: Any) -> AirState:
    """Air of all channels from a sensor_msgs/JointState of the driver."""
    channels = tuple(message.name)
    if not channels or len(set(channels)) < len(channels):
        raise ValueError(f"name: expected channel names without duplicates, got {list(channels)}")
    return AirState(
        channels,
        _finite("position", message.position, len(channels)),
        _finite("effort", message.effort, len(channels)),
    )


def read_touching(message: Any) -> frozenset[str]:
    """Names of the bodies that touch the object, from the namespaces `<body>/<body>` of a
    MarkerArray.
    """
    pairs = [
        tuple(name.split("/"))
        for name in {marker.ns for marker in message.markers if marker.action == MARKER_ADD}
    ]
    for pair in pairs:
        if len(pair) != 2 or not all(pair):
            raise ValueError(f"markers.ns: expected <body>/<body>, got {'/'.join(pair)!r}")
    touching = (body for pair in pairs if OBJECT in pair for body in pair if body != OBJECT)
    return frozenset(map(cut, touching))


@dataclass(frozen=True)
class NodeReport:
    """The latest diagnostics of a node.

    Attributes:
        worst: message of the worst level.
        fault: why the node does not work; empty when it does.
        preparing: whether the node is still starting up.
        received_at: monotonic wall time [s].
    """

    worst: str
    fault: str
    preparing: bool
    received_at: float


def read_report(message: Any, node: str, received_at: float) -> NodeReport | None:
    """The part of a DiagnosticArray that belongs to a node; None when there is none.

    `node` includes the namespace, as in `left/hand_sim`. A fault is a status of level ERROR, or a
    safety status that is not OK (a disabled driver).
    """
    own = [s for s in message.status if s.name == node or s.name.startswith(f"{node}:")]
    if not own:
        return None
    faults = [
        s
        for s in own
        if s.level >= LEVEL_ERROR or (s.name.endswith(SAFETY_SUFFIX) and s.level > LEVEL_OK)
    ]
    return NodeReport(
        worst=cut(max(own, key=lambda status: status.level).message),
        fault=cut("; ".join(status.message for status in faults)),
        preparing=any(pair.key == PREPARING for status in own for pair in status.values),
        received_at=received_at,
    )


def read_modes(message: Any, node: str) -> tuple[str, ...]:
    """Control modes of the channels in the driver's part of a DiagnosticArray; empty when it has
    none.
    """
    return tuple(filter(None, read_value(message, node, CONTROL_MODES_KEY).split(", ")))


def read_value(message: Any, node: str, key: str) -> str:
    """The value that a node reports under a key in a DiagnosticArray; "" when there is none."""
    own = (status for status in message.status if status.name.startswith(f"{node}:"))
    values = (pair.value for status in own for pair in status.values if pair.key == key)
    return str(next(values, ""))


@dataclass
class Feed:
    """The latest usable message of one topic.

    Attributes:
        topic, source: name of the topic, and the node that publishes it.
        arrived, arrived_wall: scene time [s] and wall time [s] of the last usable message; None
            before the first.
        each_tick: whether there is one message for every tick of the clock.
        punctual: whether the message for the last tick came in time.
        stamp: stamp of the last message [s].
        held: a message whose stamp is still ahead of the scene's time.
    """

    topic: str
    source: str
    read: Callable[[Any], Any]
    each_tick: bool = True
    value: Any = None
    arrived: float | None = None
    arrived_wall: float = 0.0
    refused: int = 0
    last_refusal: str = ""
    punctual: bool = True
    stamp: float = -math.inf
    held: Any = None

    def follow(self, take: Callable[[], Any], now: float, wall: float) -> bool:
        """Accept the newest message stamped at or before the scene's time; returns whether no newer
        one can come for that time.

        A message stamped at most MAX_STATE_LEAD ahead is kept for its time; one stamped further
        ahead comes from another clock and is accepted at once.

        Args:
            take: returns the received messages in order, then None.
            now: time of the scene [s].
            wall: monotonic wall time [s].
        """
        newest = None
        while (message := self.held or take()) is not None:
            self.held = None
            stamp = stamp_of_message(message)
            if now + SAME_STAMP_TOLERANCE < stamp <= now + MAX_STATE_LEAD:
                self.held = message
                break
            newest, self.stamp = message, stamp
        if newest is not None:
            self.accept(newest, now, wall)
        return self.held is not None or self.stamp > now - SAME_STAMP_TOLERANCE

    def accept(self, message: Any, now: float, wall: float) -> None:
        """Store the contents of a message, or refuse it as a whole and store the reason."""
        try:
            self.value = self.read(message)
        except ValueError as error:
            self.refused += 1
            self.last_refusal = cut(str(error))
            return
        self.arrived, self.arrived_wall = now, wall

    def forget(self) -> None:
        """Drop the messages received so far, which may come from a publisher that has ended."""
        self.value = self.arrived = self.held = None
        self.stamp, self.punctual = -math.inf, True

    def silent_for(self, now: float, wall: float, limit: float, limit_wall: float) -> bool:
        """Whether no message came for `limit` [s] of scene time and `limit_wall` [s] of wall
        time.
        """
        return self.arrived is None or (
            now - self.arrived > limit and wall - self.arrived_wall > limit_wall
        )


def stamp_of_message(message: Any) -> float:
    """Stamp [s] of a message, or of the first marker of an array; infinite for an array without
    markers.
    """
    if isinstance(message, (MarkerBytes, StampedBytes)):
        return message.stamp
    return seconds(message.header.stamp)
