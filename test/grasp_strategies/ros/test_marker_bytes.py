"""Markers read from bytes, against rclpy's own reading of them."""

import math

import numpy as np
import pytest
from builtin_interfaces.msg import Time
from geometry_msgs.msg import Point
from rclpy.serialization import deserialize_message, serialize_message
from std_msgs.msg import ColorRGBA
from visualization_msgs.msg import Marker, MarkerArray, MeshFile, UVCoordinate

from grasp_strategies.ros.marker_bytes import MarkerBytes
from grasp_strategies.ros.messages import stamp_of_message

STAMP = Time(sec=3, nanosec=250_000_000)


def some_text(draw):
    return "xyz/äö"[: draw.integers(0, 7)] * draw.integers(1, 4)


def marker(draw):
    """A marker with every field of changing length filled or not, at random."""
    counts = draw.integers(0, 4, 5).tolist()
    made = Marker(ns=some_text(draw), action=int(draw.integers(0, 4)), text=some_text(draw))
    made.header.stamp, made.header.frame_id = STAMP, some_text(draw)
    made.points = [Point(x=1.0)] * counts[0]
    made.colors = [ColorRGBA(r=0.5)] * counts[1]
    made.uv_coordinates = [UVCoordinate(u=0.5)] * counts[2]
    made.texture_resource, made.mesh_resource = some_text(draw), some_text(draw)
    made.texture.header.frame_id, made.texture.format = some_text(draw), some_text(draw)
    made.texture.data = bytes(counts[3])
    made.mesh_file = MeshFile(filename=some_text(draw), data=bytes(counts[4]))
    return made


@pytest.mark.parametrize("seed", range(30))
def test_names_actions_and_stamp_are_those_that_rclpy_reads(seed):
    draw = np.random.default_rng(seed)
    data = serialize_message(MarkerArray(markers=[marker(draw) for _ in range(seed % 7)]))
    expected = [(m.ns, m.action) for m in deserialize_message(data, MarkerArray).markers]
    read = MarkerBytes(data)
    assert read.markers == expected
    assert stamp_of_message(read) == (3.25 if expected else math.inf)


def test_bytes_that_end_early_or_are_no_markers_are_refused():
    draw = np.random.default_rng(1)
    last = marker(draw)
    data = serialize_message(MarkerArray(markers=[marker(draw), last]))
    seen = len(data) - len(serialize_message(MarkerArray(markers=[last])))
    for broken in (b"", data[:3], *(data[:length] for length in range(8, seen)), b"\xff" * 64):
        with pytest.raises(ValueError, match="markers: expected a MarkerArray"):
            list(MarkerBytes(broken).markers)
