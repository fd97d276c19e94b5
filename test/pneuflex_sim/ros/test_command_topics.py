"""An object that is held out to the hand by messages, each at its stamp."""

import numpy as np
import pytest
import rclpy
from geometry_msgs.msg import Transform
from rclpy.signals import SignalHandlerOptions
from ros_domain import held_domain
from ros_peer import Peer
from trajectory_msgs.msg import MultiDOFJointTrajectory, MultiDOFJointTrajectoryPoint

from pneuflex_sim.ros.command_topics import HOLD_TOPIC
from pneuflex_sim.ros.node import HandSim
from softhand_ros.topics import stamp_of_seconds

pytestmark = pytest.mark.system
PLACE = (0.3, 0.0, 0.1)  # in the wrist frame, away from the hand
STEP = 0.005


@pytest.fixture(scope="module")
def peer(tmp_path_factory):
    with held_domain() as domain:
        peer = Peer(domain, tmp_path_factory.mktemp("log"))
        values = ["lockstep:=false", "scene:=held", "object:=ball_40", f"step:={STEP}"]
        arguments = ["--ros-args", *(word for value in values for word in ("-p", value))]
        rclpy.init(args=arguments, domain_id=domain, signal_handler_options=SignalHandlerOptions.NO)
        yield peer
        peer.close()
        rclpy.try_shutdown()


@pytest.fixture(scope="module")
def node(peer):
    node = HandSim()
    yield node
    node.close()


def message(stamp=0.0, frame="wrist", name="object", transforms=1, fade=0.0):
    transform = Transform()
    transform.translation.x, transform.translation.y, transform.translation.z = PLACE
    point = MultiDOFJointTrajectoryPoint(transforms=[transform] * transforms)
    point.time_from_start.nanosec = round(1e9 * fade)
    found = MultiDOFJointTrajectory(joint_names=[name], points=[point])
    found.header.stamp, found.header.frame_id = stamp_of_seconds(stamp), frame
    return found


def send(peer, node, text):
    peer.deliver(MultiDOFJointTrajectory, HOLD_TOPIC, text)


def advance(node, duration):
    for _ in range(round(duration / STEP)):
        node.advance()


def height(node):
    return node.simulation.object_pose()[0][2]


def test_an_object_is_held_from_the_stamp_on_until_it_is_let_go(peer, node):
    now = node.simulation.time
    send(peer, node, message(stamp=now + 0.05))
    advance(node, 0.05)
    assert height(node) < 0.05
    advance(node, 0.2)
    wrist = node.simulation.wrist_pose()[0]
    assert node.simulation.object_pose()[0] == pytest.approx(wrist + np.array(PLACE), abs=1e-3)
    send(peer, node, message(transforms=0, fade=0.1))
    advance(node, 0.5)
    assert height(node) < wrist[2] - 0.2


@pytest.mark.parametrize(
    ("wrong", "reason"),
    [
        ({"frame": "world"}, "header.frame_id: expected wrist, got world"),
        ({"name": "ball"}, "joint_names: expected [object] with one point, got ['ball']"),
        (
            {"transforms": 2},
            "points.transforms: expected one, or none to release the object, got 2",
        ),
    ],
)
def test_a_message_that_cannot_be_used_is_refused_by_name(peer, node, wrong, reason):
    before = node.refusals
    send(peer, node, message(**wrong))
    advance(node, STEP)
    assert node.refusals == before + 1
    assert f"scene/hold_object: {reason}" in node.refused[0]
