"""Contents of ROS messages as checked arrays; any object with the fields will do, without ROS.

Every reader raises ValueError that names the field, what was expected and what came; such a message
is refused whole.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from grasp_strategies.pose import Pose
from grasp_strategies.scene import Array
from softhand_ros.diagnostics import PREPARING, cut

WORLD = "world"
OBJECT = "object"
SAFETY = ": safety"  # how the name of the driver's report ends that tells whether it works
OK, ERROR = b"\x00", b"\x02"  # levels of diagnostic_msgs/DiagnosticStatus
ADD = 0  # visualization_msgs/Marker.ADD; others delete


@dataclass(frozen=True)
class AirState:
    """State of the Pneumaticbox: channels, air mass [kg above rest], gauge pressure [Pa]."""

    channels: tuple[str, ...]
    air_mass: Array
    pressure: Array


def _finite(field: str, values: Sequence[float], count: int) -> Array:
    array = np.array(values, float)
    if array.shape != (count,) or not np.isfinite(array).all():
        raise ValueError(f"{field}: expected {count} finite numbers, got {array.tolist()}")
    return array


def read_pose(message: Any) -> Pose:
    """Pose in `world` of a geometry_msgs/PoseStamped."""
    if message.header.frame_id != WORLD:
        raise ValueError(f"header.frame_id: expected {WORLD}, got {message.header.frame_id!r}")
    place, rotation = message.pose.position, message.pose.orientation
    position = _finite("pose.position", (place.x, place.y, place.z), 3)
    orientation = _finite("pose.orientation", (rotation.x, rotation.y, rotation.z, rotation.w), 4)
    norm = float(np.linalg.norm(orientation))
    if abs(norm - 1.0) > 1e-2:
        raise ValueError(
            f"pose.orientation: expected a unit quaternion, got one of length {norm:.3g}"
        )
    return Pose(position, orientation / norm)


def read_force(message: Any) -> Array:
    """Force (3,) [N] of a geometry_msgs/WrenchStamped."""
    force = message.wrench.force
    return _finite("wrench.force", (force.x, force.y, force.z), 3)


def read_air_state(message: Any) -> AirState:
    """Air of all channels of a sensor_msgs/JointState as the driver publishes it."""
    channels = tuple(message.name)
    if not channels or len(set(channels)) < len(channels):
        raise ValueError(f"name: expected channel names that differ, got {list(channels)}")
    return AirState(
        channels,
        _finite("position", message.position, len(channels)),
        _finite("effort", message.effort, len(channels)),
    )


def read_touching(message: Any) -> frozenset[str]:
    """Names of what touches the object, by the namespaces `<body>/<body>` of a MarkerArray."""
    pairs = [
        tuple(name.split("/"))
        for name in {marker.ns for marker in message.markers if marker.action == ADD}
    ]
    for pair in pairs:
        if len(pair) != 2 or not all(pair):
            raise ValueError(f"markers.ns: expected <body>/<body>, got {'/'.join(pair)!r}")
    touching = (body for pair in pairs if OBJECT in pair for body in pair if body != OBJECT)
    return frozenset(map(cut, touching))


@dataclass(frozen=True)
class NodeReport:
    """What a node said of itself last.

    `worst`: its worst sentence; `fault`: why it does not do its work, empty when it does;
    `preparing`: not at work yet; `heard`: at which wall time [s].
    """

    worst: str
    fault: str
    preparing: bool
    heard: float


def read_report(message: Any, node: str, heard: float) -> NodeReport | None:
    """A node's part of a DiagnosticArray; None when the message is not that node's.

    Its name has its namespace, as in `left/hand_sim`. A fault is what it calls an error, or that
    its safety is not in operation: a driver that is disabled.
    """
    own = [s for s in message.status if s.name == node or s.name.startswith(f"{node}:")]
    if not own:
        return None
    faults = [s for s in own if s.level >= ERROR or (s.name.endswith(SAFETY) and s.level > OK)]
    return NodeReport(
        worst=cut(max(own, key=lambda status: status.level).message),
        fault=cut("; ".join(status.message for status in faults)),
        preparing=any(pair.key == PREPARING for status in own for pair in status.values),
        heard=heard,
    )


@dataclass
class Feed:
    """The latest usable message of one topic: its contents, when it came, and what was refused.

    `source` is who publishes it; `arrived` is the scene time [s] and `arrived_wall` the wall time
    [s] of the last usable message, None before the first.
    """

    topic: str
    source: str
    read: Callable[[Any], Any]
    value: Any = None
    arrived: float | None = None
    arrived_wall: float = 0.0
    refused: int = 0
    last_refusal: str = ""

    def accept(self, message: Any, now: float, wall: float) -> None:
        """Keep the contents of a message, or refuse it whole and remember why."""
        try:
            self.value = self.read(message)
        except ValueError as error:
            self.refused += 1
            self.last_refusal = cut(str(error))
            return
        self.arrived, self.arrived_wall = now, wall

    def forget(self) -> None:
        """Drop what was received: it may be from a publisher that has ended."""
        self.value = self.arrived = None

    def silent_for(self, now: float, wall: float, limit: float, limit_wall: float) -> bool:
        """Whether nothing came for `limit` [s] of scene and `limit_wall` [s] of wall time."""
        return self.arrived is None or (
            now - self.arrived > limit and wall - self.arrived_wall > limit_wall
        )
