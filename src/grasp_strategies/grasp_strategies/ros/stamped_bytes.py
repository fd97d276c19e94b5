"""Serialised messages of a header and numbers: poses and wrenches with a stamp.

rclpy makes Python objects of every field of a message, with a check at each, which takes longer
than all other work of a strategy in a tick. Layout of the bytes: as in `marker_bytes`.
"""

from __future__ import annotations

import math
import struct
from functools import cache

from grasp_strategies.ros.marker_bytes import BODY, LITTLE_ENDIAN

POSE, WRENCH = 7, 6  # numbers of a PoseStamped and of a WrenchStamped
NUMBER = 8  # [bytes]


@cache
def _layouts(little: bool, count: int) -> tuple[struct.Struct, struct.Struct]:
    """Of a stamp and the length of the frame's name, and of so many numbers."""
    order = "<" if little else ">"
    return struct.Struct(f"{order}iII"), struct.Struct(f"{order}{count}d")


class StampedBytes:
    """The bytes of a message that has a header and then only numbers of 8 bytes.

    Attributes:
        stamp: stamp of its header [s]; infinite if the bytes end too early.
        frame: frame of its header.
        numbers: the numbers behind the header; none if the bytes end too early.

    Args:
        data: the bytes.
        count: number of the numbers.
    """

    __slots__ = ("frame", "numbers", "stamp")
    numbers: tuple[float, ...]

    def __init__(self, data: bytes, count: int) -> None:
        self.stamp, self.frame, self.numbers = math.inf, "", ()
        head, tail = _layouts(data[1:2] == bytes([LITTLE_ENDIAN]), count)
        begin = BODY + head.size
        if len(data) < begin:
            return
        sec, nanosec, length = head.unpack_from(data, BODY)
        end = begin + length
        first = end + -(end - BODY) % NUMBER
        if len(data) >= first + tail.size:
            self.stamp = sec + 1e-9 * nanosec
            self.frame = data[begin : end - 1].decode(errors="replace")
            self.numbers = tail.unpack_from(data, first)
