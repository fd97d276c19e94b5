"""Names, actions and time of the markers in a serialised visualization_msgs/MarkerArray.

rclpy makes Python objects of every point and colour of the contacts, which takes 0.25 ms for four
pairs of bodies; a strategy needs only who touches whom, and the rest of the bytes is skipped.
Layout of the bytes: CDR, OMG Common Object Request Broker Architecture 3.0, section 15.3.
"""

from __future__ import annotations

import math
import struct
from typing import NamedTuple

from softhand_ros.topics import SECOND_NS

BODY = 4  # bytes of the encapsulation header; alignment counts from its end
LITTLE_ENDIAN = 1  # its second byte


class NamedMarker(NamedTuple):
    """What a strategy reads of a marker: namespace and action."""

    ns: str
    action: int


class MarkerBytes:
    """The bytes of a MarkerArray; `stamp` [s] is that of its first marker, infinite if it has
    none.
    """

    def __init__(self, data: bytes) -> None:
        self._data = data
        self._order = "<" if data[1:2] == bytes([LITTLE_ENDIAN]) else ">"
        self.stamp = math.inf
        if len(data) >= BODY + 12:
            count, sec, nanosec = struct.unpack_from(f"{self._order}IiI", data, BODY)
            self.stamp = sec + nanosec / SECOND_NS if count else math.inf

    @property
    def markers(self) -> list[NamedMarker]:
        """All markers; raises ValueError if the bytes end too early."""
        reader = _Reader(self._data, self._order)
        try:
            return [reader.marker() for _ in range(reader.number())]
        except struct.error as error:
            raise ValueError(f"markers: expected a MarkerArray, got other bytes: {error}") from None


class _Reader:
    """Goes through the bytes of a message."""

    def __init__(self, data: bytes, order: str) -> None:
        self._data, self._at = data, BODY
        self._number = struct.Struct(f"{order}I")

    def number(self) -> int:
        """The next unsigned number of four bytes."""
        self._align(4)
        (value,) = self._number.unpack_from(self._data, self._at)
        self._at += 4
        return int(value)

    def text(self) -> str:
        """The next string."""
        length = self.number()
        begin, self._at = self._at, self._at + length
        return self._data[begin : self._at - 1].decode(errors="replace")

    def marker(self) -> NamedMarker:
        """The next marker."""
        self._header()
        name = self.text()
        self._pass(4, 2)  # id, type
        action = self.number()
        self._pass(8, 10)  # pose, scale
        self._pass(4, 6)  # colour, lifetime
        self._pass(1, 1)  # frame_locked
        self._sequence(8, 3)  # points
        self._sequence(4, 4)  # colours of points
        self.text()  # texture_resource
        self._header()  # of the texture, with its format and data
        self.text()
        self._sequence(1, 1)
        self._sequence(4, 2)  # uv_coordinates
        self.text()  # text
        self.text()  # mesh_resource
        self.text()  # of mesh_file: name and data
        self._sequence(1, 1)
        self._pass(1, 1)  # mesh_use_embedded_materials
        return NamedMarker(name, action)

    def _header(self) -> None:
        self._pass(4, 2)  # stamp
        self.text()  # frame_id

    def _align(self, size: int) -> None:
        self._at += -(self._at - BODY) % size

    def _pass(self, size: int, count: int) -> None:
        """Pass over so many numbers of a size [bytes]."""
        self._align(size)
        self._at += size * count

    def _sequence(self, size: int, each: int) -> None:
        """Pass over a sequence of elements of so many numbers of a size [bytes] each."""
        count = self.number()
        if count:
            self._pass(size, each * count)
