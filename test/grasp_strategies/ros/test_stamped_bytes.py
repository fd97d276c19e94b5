"""Poses and wrenches read from their bytes, against what rclpy has serialised."""

import math
import struct

import numpy as np
import pytest
from geometry_msgs.msg import PoseStamped, WrenchStamped
from rclpy.serialization import serialize_message

from grasp_strategies.ros.stamped_bytes import POSE, WRENCH, StampedBytes


def fill(numbers, *places):
    """Set the fields of the places, such as x, y and z, to these numbers, in order."""
    left = iter(numbers)
    for place in places:
        for name in place.get_fields_and_field_types():
            setattr(place, name, float(next(left)))


@pytest.mark.parametrize("frame", ["", "w", "world", "left/wrist", "käfig", "x" * 1000])
def test_stamp_frame_and_numbers_are_those_of_the_message(frame):
    numbers = np.random.default_rng(len(frame)).normal(size=POSE)
    pose, wrench = PoseStamped(), WrenchStamped()
    fill(numbers, pose.pose.position, pose.pose.orientation)
    fill(numbers[:WRENCH], wrench.wrench.force, wrench.wrench.torque)
    for message, count in ((pose, POSE), (wrench, WRENCH)):
        message.header.stamp.sec, message.header.stamp.nanosec = 12, 340_000_000
        message.header.frame_id = frame
        read = StampedBytes(serialize_message(message), count)
        assert (read.stamp, read.frame) == (pytest.approx(12.34), frame)
        assert read.numbers == tuple(numbers[:count])


def test_bytes_of_the_other_order_are_read_as_well():
    data = b"\0\0\0\0" + struct.pack(">iII", 1, 500_000_000, 2) + b"w\0" + bytes(2)
    read = StampedBytes(data + struct.pack(">6d", *range(WRENCH)), WRENCH)
    assert (read.stamp, read.frame, read.numbers) == (1.5, "w", tuple(range(WRENCH)))


def test_bytes_that_end_too_early_have_no_numbers():
    message = PoseStamped()
    message.header.frame_id = "world"
    whole = serialize_message(message)
    assert StampedBytes(whole, POSE).numbers
    for length in range(len(whole)):
        read = StampedBytes(whole[:length], POSE)
        assert (read.stamp, read.frame, read.numbers) == (math.inf, "", ())
