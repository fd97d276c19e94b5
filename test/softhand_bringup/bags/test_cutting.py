"""Cutting of bags: every message goes where it belongs, as it was recorded."""

import numpy as np
import pytest
import recorded_run
from rosbags.highlevel import AnyReader
from rosbags.interfaces import (
    Qos,
    QosDurability,
    QosHistory,
    QosLiveliness,
    QosReliability,
    QosTime,
)
from rosbags.rosbag2 import StoragePlugin, WriterError

from softhand_bringup.bags.writing import BagWriter, Part, cut_bag

STATE, ANGLES, OTHER = "/pneumaticbox/state", "/hand/tip_angles", "/hand/joint_states"
SECOND = 10**9


def source(folder, storage=StoragePlugin.MCAP):
    """Three topics, a message a second; stamps of reception are those of the header and 0.25 s."""
    messages = [
        (topic, t + 0.25, recorded_run.joint_state(t, ["a"], [10.0 * t + k]))
        for t in range(10)
        for k, topic in enumerate((STATE, ANGLES, OTHER))
    ]
    return recorded_run.write_bag(folder, messages, storage)


def contents(folder):
    """(topic, stamp of reception, bytes) of every message."""
    with AnyReader([folder]) as reader:
        return [(c.topic, stamp, bytes(data)) for c, stamp, data in reader.messages()]


def between(start, stop):
    return lambda topic, stamp: start * SECOND <= stamp <= stop * SECOND


@pytest.mark.parametrize("storage", list(StoragePlugin), ids=lambda s: s.name.lower())
def test_a_part_holds_its_messages_byte_for_byte_with_their_stamps(tmp_path, storage):
    bag = source(tmp_path / "bag", storage)
    cut_bag(bag, [Part(tmp_path / "part", between(3, 5))], (STATE, ANGLES))
    whole = contents(bag)
    expected = [
        entry
        for entry in whole
        if entry[0] != OTHER
        and 3 <= (entry[1] - recorded_run.WALL_START) / SECOND - 0.25 <= 5  # of the header
    ]
    assert len(expected) == 6
    assert contents(tmp_path / "part") == expected
    assert contents(bag) == whole


def test_parts_may_overlap_and_choose_by_topic(tmp_path):
    parts = [
        Part(tmp_path / "first", between(0, 6)),
        Part(tmp_path / "second", lambda topic, stamp: topic == STATE or stamp == 4 * SECOND),
    ]
    cut_bag(source(tmp_path / "bag"), parts, (STATE, ANGLES))
    count = {
        part.folder.name: [topic for topic, *_ in contents(part.folder)].count for part in parts
    }
    assert [count["first"](STATE), count["first"](ANGLES)] == [7, 7]
    assert [count["second"](STATE), count["second"](ANGLES)] == [10, 1]


def test_a_topic_without_a_message_in_the_part_is_still_in_it(tmp_path):
    cut_bag(
        source(tmp_path / "bag"),
        [Part(tmp_path / "part", lambda topic, stamp: topic == STATE)],
        (STATE, ANGLES),
    )
    with AnyReader([tmp_path / "part"]) as reader:
        assert {name: topic.msgcount for name, topic in reader.topics.items()} == {
            STATE: 10,
            ANGLES: 0,
        }


def test_the_offered_quality_of_service_goes_with_the_topic(tmp_path):
    never = QosTime(0, 0)
    offered = Qos(
        QosHistory.KEEP_LAST,
        7,
        QosReliability.RELIABLE,
        QosDurability.TRANSIENT_LOCAL,
        never,
        never,
        QosLiveliness.AUTOMATIC,
        never,
        False,
    )
    bag = BagWriter(tmp_path / "bag")
    topic = bag.add_topic(STATE, "sensor_msgs/msg/JointState", [offered])
    message = recorded_run.joint_state(1.0, ["a"], np.array([1.0]))
    data = recorded_run.STORE.serialize_cdr(message, "sensor_msgs/msg/JointState")
    bag.write(topic, 5, 5, bytes(data))
    bag.close()
    cut_bag(tmp_path / "bag", [Part(tmp_path / "part", lambda *_: True)], (STATE,))
    with AnyReader([tmp_path / "part"]) as reader:
        (connection,) = reader.connections
        assert connection.ext.offered_qos_profiles == [offered]


def test_a_topic_that_is_not_there_is_named_and_nothing_is_written(tmp_path):
    part = Part(tmp_path / "part", lambda *_: True)
    with pytest.raises(ValueError, match=r"expected the topic /hand/angles, got /hand/joint_st"):
        cut_bag(source(tmp_path / "bag"), [part], (STATE, "/hand/angles"))
    assert not part.folder.exists()


def test_a_folder_that_exists_is_not_overwritten(tmp_path):
    (tmp_path / "part").mkdir()
    (tmp_path / "part" / "kept").write_text("x")
    with pytest.raises(WriterError, match="exists"):
        cut_bag(
            source(tmp_path / "bag"), [Part(tmp_path / "part", lambda *_: True)], (STATE, ANGLES)
        )
    assert [path.name for path in (tmp_path / "part").iterdir()] == ["kept"]
