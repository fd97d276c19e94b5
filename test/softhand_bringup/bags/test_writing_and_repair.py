"""Bags: what is written can be read by an independent reader, also after the writer was killed."""

import random
import resource
import shutil

import pytest
from rosbags.highlevel import AnyReader
from rosbags.interfaces import (
    Qos,
    QosDurability,
    QosHistory,
    QosLiveliness,
    QosReliability,
    QosTime,
)
from rosbags.rosbag2 import WriterError
from rosbags.typesys import Stores, get_typestore

from softhand_bringup.bags.repair import main, recover, repair
from softhand_bringup.bags.writing import BagWriter, UnwritableBag

TYPES = get_typestore(Stores.ROS2_JAZZY)
STRING = TYPES.types["std_msgs/msg/String"]
LATCHED = Qos(
    QosHistory.KEEP_LAST,
    1,
    QosReliability.RELIABLE,
    QosDurability.TRANSIENT_LOCAL,
    QosTime(0, 0),
    QosTime(0, 0),
    QosLiveliness.AUTOMATIC,
    QosTime(0, 0),
    False,
)


def write_strings(folder, count, *, closed):
    bag = BagWriter(folder)
    first = bag.add_topic("/a", "std_msgs/msg/String", [LATCHED])
    second = bag.add_topic("/b", "std_msgs/msg/String", [])
    for number in range(count):
        data = bytes(TYPES.serialize_cdr(STRING(data=f"text {number}"), "std_msgs/msg/String"))
        bag.write((first, second)[number % 2], 1000 + number, 900 + number, data)
        if number % 10 == 9:
            bag.flush()
    if closed:
        bag.close()
    else:
        bag.flush()
    return bag


def read_strings(folder):
    with AnyReader([folder]) as reader:
        return [
            (connection.topic, stamp, reader.deserialize(data, connection.msgtype).data)
            for connection, stamp, data in reader.messages()
        ]


def expected_strings(count):
    return [(("/a", "/b")[n % 2], 1000 + n, f"text {n}") for n in range(count)]


def test_a_closed_bag_is_read_back_whole_with_its_offered_qos(tmp_path):
    folder = tmp_path / "bag"
    write_strings(folder, 45, closed=True)
    assert sorted(p.name for p in folder.iterdir()) == ["bag_0.mcap", "metadata.yaml"]
    assert read_strings(folder) == expected_strings(45)
    with AnyReader([folder]) as reader:
        offered = {c.topic: c.ext.offered_qos_profiles for c in reader.connections}
    assert offered["/a"][0].durability == QosDurability.TRANSIENT_LOCAL


def test_a_cut_off_bag_is_repaired_to_every_flushed_message(tmp_path):
    folder = tmp_path / "bag"
    write_strings(folder, 45, closed=False)
    assert not (folder / "metadata.yaml").exists()
    assert repair(folder) == 45
    assert sorted(p.name for p in folder.iterdir()) == ["bag_0.mcap", "metadata.yaml"]
    assert read_strings(folder) == expected_strings(45)


@pytest.mark.parametrize("lost", [1, 7, 100, 400, 1500])
def test_a_file_that_breaks_off_anywhere_keeps_all_messages_before_the_break(tmp_path, lost):
    write_strings(tmp_path / "bag", 45, closed=False)
    content = (tmp_path / "bag" / "bag_0.mcap").read_bytes()
    texts = [m.data[8:-1].decode() for m in recover(content[:-lost])]
    assert texts == [f"text {n}" for n in range(len(texts))]
    # each message takes at most 70 bytes, an index at most 200: nothing but the end may be missing
    assert 45 - len(texts) <= 2 + lost / 40


@pytest.mark.parametrize("tail", [bytes(3000), b"\xff" * 50], ids=["zeros", "nonsense"])
@pytest.mark.parametrize("lost", [0, 300])
def test_what_a_power_cut_leaves_behind_the_messages_is_passed_over(tmp_path, lost, tail):
    write_strings(tmp_path / "bag", 45, closed=False)
    path = tmp_path / "bag" / "bag_0.mcap"
    content = path.read_bytes()
    path.write_bytes(content[: len(content) - lost] + tail)
    saved = repair(tmp_path / "bag")
    assert 45 - 2 - lost / 40 <= saved <= 45
    # the message at the break may end in what is behind it
    texts = [m.data[8:-1].decode() for m in list(recover(path.read_bytes()))[: saved - 1]]
    assert texts == [f"text {n}" for n in range(saved - 1)]


def test_a_bag_renamed_after_the_crash_is_repaired_under_its_new_name(tmp_path):
    write_strings(tmp_path / "bag", 20, closed=False)
    shutil.move(tmp_path / "bag", tmp_path / "kept")
    repair(tmp_path / "kept")
    assert sorted(p.name for p in (tmp_path / "kept").iterdir()) == ["kept_0.mcap", "metadata.yaml"]
    assert read_strings(tmp_path / "kept") == expected_strings(20)


def test_a_whole_bag_is_left_alone(tmp_path, capsys):
    write_strings(tmp_path / "bag", 5, closed=True)
    before = (tmp_path / "bag" / "bag_0.mcap").read_bytes()
    assert main([str(tmp_path / "bag")]) == 1
    assert "got one that needs no repair" in capsys.readouterr().err
    assert (tmp_path / "bag" / "bag_0.mcap").read_bytes() == before


@pytest.mark.parametrize("content", [b"not a bag", b"not", b""])
def test_a_file_that_is_no_bag_is_refused_with_its_first_bytes(tmp_path, content):
    (tmp_path / "x_0.mcap").write_bytes(content)
    with pytest.raises(ValueError, match=f"expected an MCAP file.*{content[:8].decode()}"):
        repair(tmp_path)
    assert (tmp_path / "x_0.mcap").read_bytes() == content


def test_an_existing_folder_is_not_overwritten(tmp_path):
    with pytest.raises(WriterError, match="exists already"):
        BagWriter(tmp_path)


def test_a_type_without_definition_is_refused_by_name(tmp_path):
    bag = BagWriter(tmp_path / "bag")
    with pytest.raises(ValueError, match="topic /x.*my_msgs/msg/Thing"):
        bag.add_topic("/x", "my_msgs/msg/Thing", [])


@pytest.mark.parametrize("seed", range(60))
def test_a_bag_with_damaged_bytes_is_repaired_or_refused_in_one_line(tmp_path, capsys, seed):
    write_strings(tmp_path / "bag", 45, closed=False)
    path, chance = tmp_path / "bag" / "bag_0.mcap", random.Random(seed)
    content = bytearray(path.read_bytes())
    for _ in range(chance.choice((1, 10, 100))):
        content[chance.randrange(len(content))] = chance.randrange(256)
    path.write_bytes(content)
    status = main([str(tmp_path / "bag")])
    said = capsys.readouterr()
    assert len((said.out + said.err).splitlines()) == 1
    if status:
        assert str(path) in said.err
        assert path.read_bytes() == content and not (tmp_path / "bag" / "repair").exists()
    else:
        with AnyReader([tmp_path / "bag"]) as reader:
            assert reader.message_count <= 45


def test_damage_in_one_chunk_leaves_those_after_it(tmp_path):
    write_strings(tmp_path / "bag", 40, closed=False)
    path = tmp_path / "bag" / "bag_0.mcap"
    content = bytearray(path.read_bytes())
    start = content.rindex(b"\x05", 0, content.index(b"text 15") - 20)  # of its record
    content[start + 1 : start + 9] = b"\xff" * 8
    path.write_bytes(content)
    texts = [m.data[8:-1].decode() for m in recover(bytes(content))]
    assert texts[:15] == [f"text {n}" for n in range(15)]
    assert texts[-20:] == [f"text {n}" for n in range(20, 40)]


@pytest.fixture
def no_room():
    """A function that limits the size of files [bytes], as a full disk does."""
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    yield lambda size: resource.setrlimit(resource.RLIMIT_FSIZE, (size, before[1]))
    resource.setrlimit(resource.RLIMIT_FSIZE, before)


def test_a_full_disk_is_told_once_with_what_is_kept_and_how_to_repair_elsewhere(tmp_path, no_room):
    folder = tmp_path / "bag"
    bag = BagWriter(folder)
    topic = bag.add_topic("/a", "std_msgs/msg/String", [])
    data = bytes(TYPES.serialize_cdr(STRING(data="x" * 1000), "std_msgs/msg/String"))
    no_room(20_000)
    with pytest.raises(UnwritableBag, match="repair-bag .*--out FOLDER") as caught:
        for number in range(100):
            bag.write(topic, number, number, data)
            if number % 5 == 4:
                bag.flush()
    bag.close()  # there is nothing left to do
    kept = int(str(caught.value).split("; ")[1].split()[0])
    assert 10 <= kept <= 20
    with pytest.raises(UnwritableBag):
        no_room(5_000)
        repair(folder)
    assert [path.name for path in folder.iterdir()] == ["bag_0.mcap"]
    no_room(resource.RLIM_INFINITY)
    assert main([str(folder), "--out", str(tmp_path / "whole")]) == 0
    assert kept <= len(read_strings(tmp_path / "whole")) <= kept + 5
    assert [path.name for path in folder.iterdir()] == ["bag_0.mcap"]


def test_a_disk_that_is_full_at_the_end_is_told_too(tmp_path, no_room):
    bag = write_strings(tmp_path / "bag", 45, closed=False)
    no_room((tmp_path / "bag" / "bag_0.mcap").stat().st_size + 10)
    with pytest.raises(UnwritableBag, match="45 of 45 messages are kept"):
        bag.close()
    no_room(resource.RLIM_INFINITY)
    assert repair(tmp_path / "bag") == 45
