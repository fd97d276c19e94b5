"""Markers for viewers and for the sequencer: `hand/contacts` and `hand/markers`.

A skin has thousands of points, and rclpy takes some 5 us to serialise each. From one message to the
next only numbers at fixed offsets change, so messages are serialised once and updated in place.
"""

from __future__ import annotations

import struct
from collections.abc import Callable, Mapping
from itertools import chain
from typing import Any

import numpy as np
from builtin_interfaces.msg import Time
from geometry_msgs.msg import Point
from numpy.typing import NDArray
from rclpy.node import Node
from rclpy.qos import QoSProfile
from rclpy.serialization import serialize_message
from visualization_msgs.msg import Marker, MarkerArray

from pneuflex_sim.pictures.render import Color
from pneuflex_sim.pictures.surfaces import SceneSurfaces, contact_line, total_arrow, total_force
from pneuflex_sim.scene.contacts import Contact, by_pair
from pneuflex_sim.simulation import Simulation
from softhand_ros.topics import has_subscribers

WORLD = "world"
FORCE_COLOR: Color = (0.9, 0.2, 0.0, 1.0)
MARKER_LINE_WIDTH, CONTACT_BALL_SIZE, ARROW_SHAFT_WIDTH, ARROW_HEAD_WIDTH = (
    0.002,
    0.004,
    0.004,
    0.010,
)  # [m]
# bytes of a serialised MarkerArray before its first marker: representation, count
MESSAGE_PREFIX = 8
TIME_PLACEHOLDER = np.array([123456789, 987654321], np.int32)  # s and ns, found again in a message
TWO_TIMES = struct.Struct("=2i")  # as they stand in a message
FORCE_TEXT_LENGTH, TEXT_PLACEHOLDER = (
    12,
    "#",
)  # characters of a force at least, and what stands for one


class SerialisedMessage:
    """The bytes of a message (CDR), with writable views of numbers in them."""

    def __init__(self, data: bytes) -> None:
        self._data = bytearray(data)

    def view(self, numbers: NDArray[Any]) -> NDArray[Any]:
        """Writable view of the bytes that hold these numbers now.

        Raises ValueError unless the numbers are in the message exactly once.

        >>> message = SerialisedMessage(np.arange(4.0).tobytes())
        >>> message.view(np.array([[1.0, 2.0]]))[:] = 7.0
        >>> np.frombuffer(message.data).tolist()
        [0.0, 7.0, 7.0, 3.0]
        """
        found = np.frombuffer(self._data, numbers.dtype, numbers.size, self.place(numbers))
        return found.reshape(numbers.shape)

    def place(self, numbers: NDArray[Any]) -> int:
        """Index of the first byte of these numbers; raises as `view` does."""
        wanted = numbers.tobytes()
        count = self._data.count(wanted)
        if count != 1:
            raise ValueError(f"expected these numbers once in the serialized message, got {count}")
        return self._data.find(wanted)

    def write(self, layout: struct.Struct, place: int, *values: Any) -> None:
        """Write values, packed by `layout`, at the byte `place`; for a few dozen numbers faster
        than a view.
        """
        layout.pack_into(self._data, place, *values)

    @property
    def data(self) -> bytes:
        """The present bytes of the message."""
        return bytes(self._data)


class SceneMarkers:
    """Markers of one simulation; computed only while somebody subscribes."""

    def __init__(self, node: Node, simulation: Simulation, qos: QoSProfile) -> None:
        self._simulation = simulation
        self._contacts = node.create_publisher(MarkerArray, "hand/contacts", qos)
        self._markers = node.create_publisher(MarkerArray, "hand/markers", qos)
        self._surfaces = SurfaceMarkers(SceneSurfaces(simulation))
        self._lines = ContactMarkers()
        self._arrows: set[str] = set()

    def publish_contacts(self, stamp: Time) -> None:
        """Publish the present contacts on `hand/contacts`."""
        if has_subscribers(self._contacts):
            self._contacts.publish(self._lines.message(stamp, by_pair(self._simulation.contacts())))

    def publish_markers(self, stamp: Time) -> None:
        """Publish the present surfaces and forces on `hand/markers`."""
        if has_subscribers(self._markers):
            self._markers.publish(self._surfaces.message(stamp))
            self._markers.publish(self._force_markers(stamp))

    def _force_markers(self, stamp: Time) -> MarkerArray:
        """The contact points, and an arrow for each pair of bodies in contact; arrows of pairs that
        have separated are deleted.
        """
        found = self._simulation.contacts()
        pairs = by_pair(found)
        markers = [
            _marker(stamp, f"force/{pair}", Marker.ARROW, Marker.DELETE)
            for pair in sorted(self._arrows - set(pairs))
        ]
        markers.append(_contact_points(stamp, found))
        for pair, contacts in pairs.items():
            arrow = _marker(stamp, f"force/{pair}", Marker.ARROW)
            arrow.scale.x, arrow.scale.y, arrow.scale.z = (
                ARROW_SHAFT_WIDTH,
                ARROW_HEAD_WIDTH,
                ARROW_HEAD_WIDTH,
            )
            arrow.points = _points(total_arrow(contacts))
            _paint(arrow, FORCE_COLOR)
            markers.append(arrow)
        self._arrows = set(pairs)
        return MarkerArray(markers=markers)


class ContactMarkers:
    """A marker for each pair of bodies: a line at each contact, the pair's name as `ns`, and as
    text the sum of the pair's normal forces [N]. Kept small, as the sequencer reads them 50 times a
    second.

    rclpy takes 0.2 ms to make and serialise a marker. So each pair with a given number of contacts
    is serialised once, and its numbers are changed.
    """

    def __init__(self) -> None:

        def clear(text: str) -> Marker:
            marker = _marker(_stamp(TIME_PLACEHOLDER), "", Marker.CUBE, Marker.DELETEALL)
            marker.text = text.replace(TEXT_PLACEHOLDER, " ")
            return marker

        self._clear = _serialised(clear, "")[0]
        self._time = self._clear.view(TIME_PLACEHOLDER)
        self._lines: dict[tuple[str, int], _Lines] = {}

    def message(self, stamp: Time, pairs: Mapping[str, list[Contact]]) -> bytes:
        """The MarkerArray of these contacts, serialised; first it deletes all earlier ones."""
        self._time[:] = stamp.sec, stamp.nanosec
        clear = self._clear.data
        parts = [clear[MESSAGE_PREFIX:]]
        for pair, contacts in pairs.items():
            key = pair, len(contacts)
            if key not in self._lines:
                self._lines[key] = _Lines(*key)
            parts.append(self._lines[key].data(stamp, contacts))
        count = np.array([len(parts)], "<u4").tobytes()
        return clear[: MESSAGE_PREFIX - len(count)] + count + b"".join(parts)


class _Lines:
    """The marker of a pair of bodies with a given number of contacts, as it stands in a serialised
    array.
    """

    def __init__(self, pair: str, count: int) -> None:
        points = np.random.default_rng(0).uniform(size=(2 * count, 3))

        def lines(text: str) -> Marker:
            marker = _marker(_stamp(TIME_PLACEHOLDER), pair, Marker.LINE_LIST)
            marker.scale.x, marker.points, marker.text = MARKER_LINE_WIDTH, _points(points), text
            _paint(marker, FORCE_COLOR)
            return marker

        self._message, text = _serialised(lines, FORCE_TEXT_LENGTH * TEXT_PLACEHOLDER)
        self._width, place = len(text), self._message.place
        self._time, self._points = place(TIME_PLACEHOLDER), place(points)
        self._text = place(np.frombuffer(text.encode(), np.uint8))
        self._all_points, self._whole_text = (
            struct.Struct(f"={points.size}d"),
            struct.Struct(f"{self._width}s"),
        )

    def data(self, stamp: Time, contacts: list[Contact]) -> bytes:
        """Its bytes now."""
        width, force, write = self._width, total_force(contacts), self._message.write
        text = f"{force:{width}.4f}"
        text = text if len(text) == width else f"{force:{width}.3e}"
        write(self._whole_text, self._text, text.encode())
        write(TWO_TIMES, self._time, stamp.sec, stamp.nanosec)
        points = chain.from_iterable(map(contact_line, contacts))
        write(self._all_points, self._points, *points)
        return self._message.data[MESSAGE_PREFIX:]


def _serialised(make: Callable[[str], Marker], text: str) -> tuple[SerialisedMessage, str]:
    """An array of the one marker that `make` returns for a text, padded so that other markers can
    follow it; and the text, with up to four characters added.

    Numbers of 8 bytes are aligned to multiples of 8 (CDR). So the bytes of a marker do not depend
    on where it begins if their length is such a multiple, and four more characters shift it by
    four.
    """
    data = serialize_message(MarkerArray(markers=[make(text)]))
    data += bytes(-len(data) % 4)
    if (len(data) - MESSAGE_PREFIX) % 8:
        return _serialised(make, text + 4 * TEXT_PLACEHOLDER)
    return SerialisedMessage(data), text


class SurfaceMarkers:
    """A marker of triangles for each part of hand, object and scene, with the part's name as
    `ns`.
    """

    def __init__(self, surfaces: SceneSurfaces) -> None:
        self._surfaces = surfaces
        draw, markers = np.random.default_rng(0), []
        fields: dict[str, tuple[NDArray[Any], ...]] = {}
        for name, (corners, _) in surfaces.now().items():
            color = draw.uniform(0.1, 0.9, 4).astype(np.float32)
            corner, time = draw.uniform(size=3), draw.integers(1, 2**30, 2, dtype=np.int32)
            marker = _marker(_stamp(time), name, Marker.TRIANGLE_LIST)
            marker.scale.x = marker.scale.y = marker.scale.z = 1.0
            marker.points = _points(corner[None]) * len(corners)
            _paint(marker, tuple(color.tolist()))
            markers.append(marker)
            fields[name] = (time, color, np.tile(corner, (len(corners), 1)))
        self._message = SerialisedMessage(serialize_message(MarkerArray(markers=markers)))
        self._fields = {
            name: tuple(self._message.view(part) for part in numbers)
            for name, numbers in fields.items()
        }

    def message(self, stamp: Time) -> bytes:
        """The MarkerArray of the present surfaces, serialised."""
        for name, (corners, color) in self._surfaces.now().items():
            time, shown_color, shown = self._fields[name]
            time[:], shown_color[:], shown[:] = (stamp.sec, stamp.nanosec), color, corners
        return self._message.data


def _contact_points(stamp: Time, contacts: list[Contact]) -> Marker:
    """A ball at each contact; without any the marker is deleted."""
    action = Marker.ADD if contacts else Marker.DELETE
    balls = _marker(stamp, "contacts", Marker.SPHERE_LIST, action)
    balls.scale.x = balls.scale.y = balls.scale.z = CONTACT_BALL_SIZE
    balls.points = _points(np.array([contact.position for contact in contacts]))
    _paint(balls, FORCE_COLOR)
    return balls


def _marker(stamp: Time, namespace: str, kind: int, action: int = Marker.ADD) -> Marker:
    """A marker in the world; it is the only one of its namespace."""
    marker = Marker(ns=namespace, type=kind, action=action)
    marker.header.stamp, marker.header.frame_id = stamp, WORLD
    marker.pose.orientation.w = 1.0
    return marker


def _stamp(time: NDArray[np.int32]) -> Time:
    return Time(sec=int(time[0]), nanosec=int(time[1]))


def _points(places: np.ndarray) -> list[Point]:
    return [Point(x=x, y=y, z=z) for x, y, z in places.tolist()]


def _paint(marker: Marker, color: Color) -> None:
    marker.color.r, marker.color.g, marker.color.b, marker.color.a = map(float, color)
