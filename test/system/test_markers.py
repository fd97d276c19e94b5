"""A viewer beside a running simulator."""

from dataclasses import replace

import numpy as np
from visualization_msgs.msg import Marker, MarkerArray

from softhand_bringup.bags.reading import stamp_seconds
from softhand_bringup.processes import suite


def test_a_viewer_sees_hand_and_scene_ten_times_a_second(launcher, options, peer):
    # in real time: 50 messages of history are 2.5 s then, also for a viewer on a busy machine
    launcher.start(suite.simulator(replace(options, real_time_factor=1.0)))
    seen = peer.listen(MarkerArray, "hand/markers")
    peer.wait(lambda: len(seen) >= 22, "hand/markers")
    surfaces = [message.markers for message in seen if len(message.markers) > 10][:10]
    times = [stamp_seconds(markers[0].header.stamp) for markers in surfaces]
    np.testing.assert_allclose(np.diff(times), 0.1, atol=1e-9)
    names = {marker.ns for marker in surfaces[0]}
    assert {"thumb", "index", "palm_inner", "plate", "sheet", "object", "table"} <= names
    top = max(point.z for marker in surfaces[0] if marker.ns == "table" for point in marker.points)
    assert abs(top) < 1e-9
    assert all(marker.type == Marker.TRIANGLE_LIST for marker in surfaces[0])
