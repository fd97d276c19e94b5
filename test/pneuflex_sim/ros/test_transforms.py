"""Frames of wrist and object: parents, names and poses; /tf where its messages are there."""

from types import SimpleNamespace

import numpy as np
import pytest
from builtin_interfaces.msg import Time

from pneuflex_sim.ros import transforms
from pneuflex_sim.ros.transforms import NO_TF_MESSAGE, Transforms, frames, stamped
from softhand_model.hand.hand import WRIST

STAMP = Time(sec=3, nanosec=20_000_000)


class Node:
    """Keeps what it is asked to publish and to log."""

    def __init__(self, namespace="/"):
        self.namespace, self.topics, self.lines = namespace, [], []

    def get_namespace(self):
        return self.namespace

    def get_logger(self):
        return SimpleNamespace(info=self.lines.append)

    def create_publisher(self, kind, topic, qos):
        self.topics.append((topic, qos.depth))
        return SimpleNamespace(publish=self.lines.append)


@pytest.fixture
def moved(simulate):
    """A hand on its way down to a cylinder that does not stand at the origin."""
    simulation = simulate(step=0.005, object_offset=(0.02, 0.01))
    simulation.command_wrist(np.array([-0.04, 0.0, 0.11]), np.array([0.0, 0.83, 0.0, 0.56]))
    for _ in range(40):
        simulation.step()
    return simulation


def test_wrist_and_object_hang_in_the_world_at_their_poses(moved):
    wrist, thing = frames(moved, "")
    assert (wrist.parent, wrist.name) == ("world", WRIST)
    assert (thing.parent, thing.name) == ("world", "object")
    np.testing.assert_array_equal(wrist.position, moved.wrist_pose()[0])
    np.testing.assert_array_equal(wrist.orientation, moved.wrist_pose()[1])
    np.testing.assert_array_equal(thing.position, moved.object_pose()[0])
    assert thing.position[0] == pytest.approx(0.02, abs=0.002)


def test_names_have_the_prefix_and_the_world_is_one_for_all(moved):
    assert [(f.parent, f.name) for f in frames(moved, "left/")] == [
        ("world", "left/wrist"),
        ("world", "left/object"),
    ]


def test_a_scene_without_an_object_has_the_wrist_alone(simulate):
    simulation = simulate(step=0.005, hand="single_finger", scene="stand")
    assert [frame.name for frame in frames(simulation, "")] == ["wrist"]


def test_a_message_tells_a_frame(moved):
    frame = frames(moved, "left/")[0]
    message = stamped(frame, STAMP)
    assert (message.header.frame_id, message.child_frame_id) == ("world", "left/wrist")
    assert message.header.stamp == STAMP
    place, turn = message.transform.translation, message.transform.rotation
    np.testing.assert_array_equal((place.x, place.y, place.z), frame.position)
    np.testing.assert_array_equal((turn.x, turn.y, turn.z, turn.w), frame.orientation)


def test_without_the_messages_one_line_says_so_and_nothing_is_published(moved, monkeypatch):
    monkeypatch.setattr(transforms, "TFMessage", None)
    node = Node()
    made = Transforms(node, moved)
    for _ in range(3):
        made.publish(STAMP)
    assert (node.topics, node.lines) == ([], [NO_TF_MESSAGE])


def test_with_the_messages_all_frames_go_out_in_one(moved, monkeypatch):
    monkeypatch.setattr(transforms, "TFMessage", SimpleNamespace)
    node = Node("/left")
    Transforms(node, moved).publish(STAMP)
    assert node.topics == [("/tf", 100)]
    (sent,) = node.lines
    assert [message.child_frame_id for message in sent.transforms] == ["left/wrist", "left/object"]
