"""A viewer beside a running simulator."""

import numpy as np
from visualization_msgs.msg import Marker, MarkerArray

from softhand_bringup.bags.reading import stamp_seconds
from softhand_bringup.processes import suite


def test_a_viewer_sees_hand_and_scene_ten_times_a_second(launcher, options, peer):
    launcher.start(suite.simulator(options))
    seen = peer.listen(MarkerArray, "hand/markers")
    peer.wait(lambda: len(seen) >= 22, 60.0, "hand/markers")
    surfaces = [message.markers for message in seen if len(message.markers) > 10][:10]
    times = [stamp_seconds(markers[0].header.stamp) for markers in surfaces]
    gaps = np.diff(times)  # a busy viewer sees the latest and misses some between
    np.testing.assert_allclose(gaps, 0.1 * np.round(gaps / 0.1), atol=1e-9)
    assert gaps.min() > 0.05 and np.median(gaps) < 0.15
    names = {marker.ns for marker in surfaces[0]}
    assert {"thumb", "index", "palm_inner", "plate", "sheet", "object", "table"} <= names
    top = max(point.z for marker in surfaces[0] if marker.ns == "table" for point in marker.points)
    assert abs(top) < 1e-9
    assert all(marker.type == Marker.TRIANGLE_LIST for marker in surfaces[0])
