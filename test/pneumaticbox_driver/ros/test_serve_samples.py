"""Samples from a topic: only the topic backend has them."""

import pytest
import rclpy
from plant_peer import BOX
from rclpy.signals import SignalHandlerOptions

from pneumaticbox_driver.ros.node import PneumaticBoxNode

pytestmark = pytest.mark.system


@pytest.fixture
def node(domain, monkeypatch):
    """A driver with the embedded backend, in this process."""
    monkeypatch.setenv("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
    values = {**BOX, "backend": "embedded"}
    words = [word for name, value in values.items() for word in ("-p", f"{name}:={value}")]
    rclpy.init(
        args=["--ros-args", *(word.replace("'", '"') for word in words)],
        domain_id=domain,
        signal_handler_options=SignalHandlerOptions.NO,
    )
    node = PneumaticBoxNode()
    yield node
    node.close()
    rclpy.try_shutdown()


def test_serve_samples_refuses_a_backend_without_the_topic_of_the_sensors(node):
    with pytest.raises(RuntimeError, match="serve_samples: expected backend topic, got embedded"):
        node.serve_samples(0.0)
    assert not node.box.latch  # a mistake of the caller, not a fault of the box
