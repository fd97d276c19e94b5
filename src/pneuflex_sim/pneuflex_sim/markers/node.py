"""Publishes what is to be seen: `hand/contacts`, `hand/markers` and, where tf2 is installed, where
the wrist is.
"""

from __future__ import annotations

import numpy as np
from builtin_interfaces.msg import Time
from geometry_msgs.msg import Point, TransformStamped
from rclpy.node import Node
from rclpy.qos import QoSProfile
from rclpy.serialization import serialize_message
from visualization_msgs.msg import Marker, MarkerArray

from pneuflex_sim.contacts import by_pair
from pneuflex_sim.markers.forces import contact_lines, total_arrow, total_force
from pneuflex_sim.markers.serialised import SerialisedMessage
from pneuflex_sim.markers.surfaces import SceneSurfaces
from pneuflex_sim.render import Color
from pneuflex_sim.simulation import Simulation

try:  # not in common_interfaces, and not on PyPI: only where ROS 2 is installed
    from tf2_msgs.msg import TFMessage
except ImportError:
    TFMessage = None

WORLD, WRIST = "world", "wrist"
FORCE_COLOR: Color = (0.9, 0.2, 0.0, 1.0)
LINE_WIDTH, BALL, SHAFT, HEAD = 0.002, 0.004, 0.004, 0.010  # [m]
LINES, POINTS = 0, 1  # ids of the markers of a pair of bodies


class SeenScene:
    """Markers of one simulation. Nothing is made that nobody has subscribed to."""

    def __init__(self, node: Node, simulation: Simulation, qos: QoSProfile) -> None:
        self._simulation = simulation
        self._contacts = node.create_publisher(MarkerArray, "hand/contacts", qos)
        self._markers = node.create_publisher(MarkerArray, "hand/markers", qos)
        self._frames = TFMessage and node.create_publisher(TFMessage, "/tf", qos)
        self._surfaces = SurfaceMarkers(SceneSurfaces(simulation))
        self._arrows: set[str] = set()

    def publish_contacts(self, stamp: Time) -> None:
        """Contacts now, and the frame of the wrist."""
        if self._contacts.get_subscription_count():
            self._contacts.publish(self._contact_markers(stamp))
        if self._frames is not None and self._frames.get_subscription_count():
            frame = wrist_frame(stamp, *self._simulation.wrist_pose())
            self._frames.publish(TFMessage(transforms=[frame]))

    def publish_markers(self, stamp: Time) -> None:
        """Surfaces and forces now."""
        if self._markers.get_subscription_count():
            self._markers.publish(self._surfaces.message(stamp))
            self._markers.publish(self._force_markers(stamp))

    def _contact_markers(self, stamp: Time) -> MarkerArray:
        """Lines and balls for each pair of bodies; the lines' text is its force [N]."""
        markers = [_marker(stamp, "", Marker.CUBE, 0, Marker.DELETEALL)]
        for pair, contacts in by_pair(self._simulation.contacts()).items():
            lines = _marker(stamp, pair, Marker.LINE_LIST, LINES)
            lines.scale.x, lines.text = LINE_WIDTH, f"{total_force(contacts):.4f}"
            lines.points = _points(contact_lines(contacts).reshape(-1, 3))
            balls = _marker(stamp, pair, Marker.SPHERE_LIST, POINTS)
            balls.scale.x = balls.scale.y = balls.scale.z = BALL
            balls.points = lines.points[::2]
            for marker in (lines, balls):
                _paint(marker, FORCE_COLOR)
            markers += [lines, balls]
        return MarkerArray(markers=markers)

    def _force_markers(self, stamp: Time) -> MarkerArray:
        """An arrow for each pair of bodies that touch; those that have parted are deleted."""
        pairs = by_pair(self._simulation.contacts())
        markers = [
            _marker(stamp, f"force/{pair}", Marker.ARROW, 0, Marker.DELETE)
            for pair in sorted(self._arrows - set(pairs))
        ]
        for pair, contacts in pairs.items():
            arrow = _marker(stamp, f"force/{pair}", Marker.ARROW, 0)
            arrow.scale.x, arrow.scale.y, arrow.scale.z = SHAFT, HEAD, HEAD
            arrow.points = _points(total_arrow(contacts))
            _paint(arrow, FORCE_COLOR)
            markers.append(arrow)
        self._arrows = set(pairs)
        return MarkerArray(markers=markers)


class SurfaceMarkers:
    """A marker for each part of hand, object and scene, `ns` = its name, all of triangles."""

    def __init__(self, surfaces: SceneSurfaces) -> None:
        self._surfaces = surfaces
        draw, markers, fields = np.random.default_rng(0), [], {}
        for name, (corners, _) in surfaces.now().items():
            color = draw.uniform(0.1, 0.9, 4).astype(np.float32)
            corner, time = draw.uniform(size=3), draw.integers(1, 2**30, 2, dtype=np.int32)
            marker = _marker(
                Time(sec=int(time[0]), nanosec=int(time[1])), name, Marker.TRIANGLE_LIST, 0
            )
            marker.scale.x = marker.scale.y = marker.scale.z = 1.0
            marker.points = _points(corner[None]) * len(corners)
            _paint(marker, tuple(color.tolist()))
            markers.append(marker)
            fields[name] = (time, color, np.tile(corner, (len(corners), 1)))
        self._message = SerialisedMessage(serialize_message(MarkerArray(markers=markers)))
        self._fields = {
            name: tuple(map(self._message.view, numbers)) for name, numbers in fields.items()
        }

    def message(self, stamp: Time) -> bytes:
        """The MarkerArray of now, serialised."""
        for name, (corners, color) in self._surfaces.now().items():
            time, shown_color, shown = self._fields[name]
            time[:], shown_color[:], shown[:] = (stamp.sec, stamp.nanosec), color, corners
        return self._message.data


def wrist_frame(stamp: Time, position: np.ndarray, orientation: np.ndarray) -> TransformStamped:
    """Where the frame `wrist` is in `world`, for tf."""
    frame = TransformStamped(child_frame_id=WRIST)
    frame.header.stamp, frame.header.frame_id = stamp, WORLD
    place, turn = frame.transform.translation, frame.transform.rotation
    place.x, place.y, place.z = map(float, position)
    turn.x, turn.y, turn.z, turn.w = map(float, orientation)
    return frame


def _marker(
    stamp: Time, namespace: str, kind: int, number: int, action: int = Marker.ADD
) -> Marker:
    marker = Marker(ns=namespace, id=number, type=kind, action=action)
    marker.header.stamp, marker.header.frame_id = stamp, WORLD
    marker.pose.orientation.w = 1.0
    return marker


def _points(places: np.ndarray) -> list[Point]:
    return [Point(x=x, y=y, z=z) for x, y, z in places.tolist()]


def _paint(marker: Marker, color: Color) -> None:
    marker.color.r, marker.color.g, marker.color.b, marker.color.a = map(float, color)
