"""The recorder as a process: everything is recorded, and a kill costs at most the last second."""

import re
import resource
import signal
import time
from dataclasses import replace

import pytest
from ros_peer import LATCHED
from sensor_msgs.msg import JointState
from std_msgs.msg import String

from softhand_bringup.bags.reading import Bag
from softhand_bringup.bags.repair import repair
from softhand_bringup.processes import suite

RATE = 500  # [Hz]


@pytest.fixture
def recorder(launcher, tmp_path):
    return launcher.start(suite.recorder(tmp_path / "bag"))


@pytest.fixture
def traffic(peer, recorder):
    """Publishes a latched text before, then numbered samples; returns the function that does."""
    text = peer.node.create_publisher(String, "robot_description", LATCHED)
    text.publish(String(data="<robot/>"))
    samples = peer.node.create_publisher(JointState, "samples", RATE)  # a second: none is lost here
    peer.wait(samples.get_subscription_count, "the recorder's subscription")

    def publish(count):
        due = time.monotonic()
        for number in range(count):
            samples.publish(JointState(position=[float(number)]))
            due += 1.0 / RATE
            time.sleep(max(0.0, due - time.monotonic()))

    return publish


def recorded(folder):
    with Bag(folder) as bag:
        numbers = [message.position[0] for _, message in bag.messages("/samples")]
        texts = [message.data for _, message in bag.messages("/robot_description")]
    return numbers, texts


def test_every_message_is_recorded_in_order_the_latched_one_too(recorder, traffic, tmp_path):
    traffic(1000)
    recorder.send(signal.SIGINT)
    assert recorder.wait(10.0) == 0
    assert recorded(tmp_path / "bag") == ([float(n) for n in range(1000)], ["<robot/>"])


def test_a_topic_that_has_a_listener_alone_is_recorded_from_its_first_message(
    recorder, peer, tmp_path
):
    peer.listen(JointState, "commands", 10)
    peer.wait(lambda: peer.node.count_subscribers("commands") == 2, "the recorder, too")
    commands = peer.node.create_publisher(JointState, "commands", 10)
    peer.wait(lambda: commands.get_subscription_count() == 2, "both of them")
    commands.publish(JointState(position=[7.0]))
    peer.spin(1.0)
    recorder.send(signal.SIGINT)
    assert recorder.wait(10.0) == 0
    with Bag(tmp_path / "bag") as bag:
        assert [message.position[0] for _, message in bag.messages("/commands")] == [7.0]


def test_a_killed_recorder_loses_at_most_what_came_after_the_last_second(
    recorder, traffic, tmp_path
):
    traffic(1500)
    recorder.send(signal.SIGKILL)
    assert recorder.wait(10.0) == -signal.SIGKILL
    repair(tmp_path / "bag")
    numbers, texts = recorded(tmp_path / "bag")
    assert numbers == [float(n) for n in range(len(numbers))]
    assert len(numbers) >= 1500 - 1.2 * RATE
    assert texts == ["<robot/>"]


def test_in_a_namespace_it_records_what_lies_below_and_what_has_no_namespace(
    launcher, peer, tmp_path
):
    command = replace(suite.recorder(tmp_path / "bag"), remappings={"__ns": "/left"})
    process = launcher.start(command)
    others = [peer.node.create_publisher(String, name, 10) for name in ("right/said", "right/told")]
    for name in ("left/said", "said"):
        peer.publish(String, name, String(data=name))
    peer.wait(lambda: peer.node.count_publishers("/diagnostics"), "the recorder's reports")
    peer.diagnosis("left/recorder")
    assert not any(publisher.get_subscription_count() for publisher in others)
    process.send(signal.SIGINT)
    assert process.wait(10.0) == 0
    with Bag(tmp_path / "bag") as bag:
        told = {name: [m.data for _, m in bag.messages(name)] for name in ("/left/said", "/said")}
    assert told == {"/left/said": ["left/said"], "/said": ["said"]}


def test_a_bag_folder_that_cannot_be_written_ends_the_recorder_with_one_line(launcher, tmp_path):
    (tmp_path / "file").write_text("")
    process = launcher.start(suite.recorder(tmp_path / "file" / "bag"))
    assert process.wait(10.0) == 1
    expected = f"recorder: cannot write the bag {tmp_path}/file/bag: Not a directory"
    assert process.output().strip() == expected


def test_a_full_disk_ends_the_recorder_in_one_sentence_and_what_is_kept_can_be_repaired(
    recorder, traffic, tmp_path
):
    traffic(600)
    bag = tmp_path / "bag"
    written = (bag / "bag_0.mcap").stat().st_size
    resource.prlimit(recorder.pid, resource.RLIMIT_FSIZE, (written + 20_000, written + 20_000))
    traffic(1000)
    assert recorder.wait(10.0) == 1
    *_, line = recorder.output().strip().splitlines()
    assert re.match(
        rf"recorder: {bag}: expected to continue writing, got File too large; \d+ of \d+ ", line
    )
    assert "softhand repair-bag" in line and "--out FOLDER" in line
    kept = int(line.split("; ")[1].split()[0])
    assert kept >= 600 - 1.2 * RATE
    assert repair(bag, tmp_path / "whole") >= kept
    numbers, _ = recorded(tmp_path / "whole")
    assert numbers == [float(n) for n in range(600)][: len(numbers)] or numbers[600] == 0.0
