"""Bags of kilobytes that unpack to gigabytes: refused in one line, with little memory and time."""

import bz2
import multiprocessing as mp
import resource
import shutil
import sqlite3
from pathlib import Path

import lz4.frame
import numpy as np
import pytest
import zstandard
from mcap.writer import CompressionType, Writer
from rosbags.rosbag2 import StoragePlugin
from rosbags.rosbag2 import Writer as BagWriter
from rosbags.rosbag2.enums import CompressionFormat, CompressionMode
from rosbags.typesys import Stores, get_typestore

from model_lab.measurements.bags.limits import LARGEST_PIECE, TooLargeBag, unpacked
from softhand_bringup.bags.reading import Bag
from softhand_bringup.bags.repair import main, repair
from softhand_common.documents.yaml_reading import LARGEST_DOCUMENT

TYPES = get_typestore(Stores.ROS2_JAZZY)
TEXT = "std_msgs/msg/String"
MEMORY = 2**29  # [bytes] beyond what the process has


def text(length):
    data = TYPES.types[TEXT](data="x" * length)
    return bytes(TYPES.serialize_cdr(data, TEXT))


def cut_bag(folder, lengths, compression):
    """An MCAP file of one text of a length in each chunk, without metadata.yaml."""
    folder.mkdir()
    with (folder / "bag_0.mcap").open("wb") as file:
        writer = Writer(file, chunk_size=1, compression=compression)
        writer.start("ros2", "test")
        schema = writer.register_schema(TEXT, "ros2msg", b"string data")
        channel = writer.register_channel("/text", "cdr", schema)
        for tick, length in enumerate(lengths):
            writer.add_message(channel, tick, text(length), tick)
        writer.finish()
    return folder


def whole_bag(folder, plugin, mode, length, count=1):
    packed = BagWriter(folder, version=9, storage_plugin=plugin)
    if mode is not None:
        packed.set_compression(mode, CompressionFormat.ZSTD)
    with packed as bag:
        topic = bag.add_connection("/text", TEXT, typestore=TYPES)
        for tick in range(count):
            bag.write(topic, tick, text(length))
    return folder


def read(folder):
    with Bag(folder) as bag:
        return sum(1 for topic in bag.topics() for _ in bag.messages(topic))


def in_little_memory(function, *arguments):
    """What a function returns, or the words of its ValueError, where memory is short."""

    def work(pipe):
        size = int(Path("/proc/self/statm").read_text().split()[0]) * resource.getpagesize()
        resource.setrlimit(resource.RLIMIT_AS, (size + MEMORY, size + MEMORY))
        try:
            pipe.send(function(*arguments))
        except ValueError as reason:
            pipe.send(str(reason))

    ours, theirs = mp.Pipe(duplex=False)
    worker = mp.get_context("fork").Process(target=work, args=(theirs,))
    worker.start()
    theirs.close()
    found = ours.recv()
    worker.join()
    return found


@pytest.mark.parametrize("compression", [CompressionType.ZSTD, CompressionType.LZ4])
def test_a_chunk_that_unpacks_to_more_than_a_chunk_may_is_refused(tmp_path, compression):
    bomb = cut_bag(tmp_path / "bag", [LARGEST_PIECE + 1], compression)
    before = [path.read_bytes() for path in bomb.iterdir()]
    words = "expected a piece of at most 67108864 bytes unpacked, got more"
    assert in_little_memory(repair, bomb) == f"{bomb}/bag_0.mcap: {words}"
    assert [path.read_bytes() for path in bomb.iterdir()] == before


def test_chunks_that_are_too_large_together_are_refused_by_command_with_nothing_left(
    tmp_path, capsys
):
    bomb = cut_bag(tmp_path / "bag", [2**24] * 8, CompressionType.ZSTD)
    assert sum(path.stat().st_size for path in bomb.iterdir()) < 2**15
    assert main([str(bomb), "--out", str(tmp_path / "whole")]) == 1
    (line,) = capsys.readouterr().err.splitlines()
    assert f"{bomb}/bag_0.mcap: expected chunks of at most" in line
    assert not (tmp_path / "whole").exists()


def test_a_size_that_is_stated_wrongly_helps_no_bomb(tmp_path):
    bomb = cut_bag(tmp_path / "bag", [LARGEST_PIECE + 1], CompressionType.ZSTD)
    path = bomb / "bag_0.mcap"
    content = path.read_bytes()
    sizes = [int.from_bytes(content[k : k + 8], "little") for k in range(len(content) - 8)]
    at = [k for k, size in enumerate(sizes) if 0 < size - LARGEST_PIECE < 2000]
    assert at, "the size stands in the chunk and in the index"
    for k in at:
        content = content[:k] + (1000).to_bytes(8, "little") + content[k + 8 :]
    path.write_bytes(content)
    assert "unpacked, got more" in in_little_memory(repair, bomb)


def test_a_chunk_within_a_chunk_is_not_unpacked(tmp_path):
    inner = cut_bag(tmp_path / "inner", [LARGEST_PIECE - 2**20], CompressionType.ZSTD)
    content = (inner / "bag_0.mcap").read_bytes()
    start = content.index(b"\x06", 8 + 9 + 20)
    chunk = content[start : start + 9 + int.from_bytes(content[start + 1 : start + 9], "little")]
    packed = zstandard.compress(chunk * 400)
    name = b"\x04\0\0\0zstd"
    body = bytes(16) + (len(chunk) * 400).to_bytes(8, "little") + bytes(4) + name
    body += len(packed).to_bytes(8, "little") + packed
    outer = content[:start] + b"\x06" + len(body).to_bytes(8, "little") + body
    (tmp_path / "outer").mkdir()
    (tmp_path / "outer" / "bag_0.mcap").write_bytes(outer)
    assert in_little_memory(repair, tmp_path / "outer") == 0


def test_whole_bags_of_chunks_that_are_too_large_are_refused(tmp_path):
    bag = whole_bag(tmp_path / "bag", StoragePlugin.MCAP, CompressionMode.STORAGE, 2**24, 8)
    said = in_little_memory(read, bag)
    assert str(bag) in said and "expected chunks of at most" in said and "\n" not in said


def test_chunks_without_an_index_are_counted(tmp_path):
    """A scan would unpack one after the other, many times 16 MB."""
    bag = whole_bag(tmp_path / "bag", StoragePlugin.MCAP, CompressionMode.STORAGE, 2**24, 8)
    (path,) = bag.glob("*.mcap")
    content = path.read_bytes()
    footer = content.rindex(b"\x02\x14" + bytes(7))
    path.write_bytes(content[: footer + 9] + bytes(8) + content[footer + 17 :])  # no summary
    assert "expected chunks of at most" in in_little_memory(read, bag)


def test_messages_that_are_too_large_together_are_refused(tmp_path):
    bag = whole_bag(tmp_path / "bag", StoragePlugin.SQLITE3, CompressionMode.MESSAGE, 2**24, 8)
    assert "expected messages of at most" in in_little_memory(read, bag)


def test_a_topic_that_is_there_twice_is_refused(tmp_path):
    """Each of its messages would come once for each, sorted in memory."""
    bag = whole_bag(tmp_path / "bag", StoragePlugin.SQLITE3, None, 10)
    (path,) = bag.glob("*.db3")
    with sqlite3.connect(path) as database:
        database.executescript(
            "CREATE TABLE other AS SELECT * FROM topics; INSERT INTO other SELECT * FROM topics;"
            "DROP TABLE topics; ALTER TABLE other RENAME TO topics"
        )
    with pytest.raises(ValueError, match=r"bag: .*expected every topic once, got 1 again"):
        read(bag)


@pytest.mark.parametrize("stamp", ["-1", "1e30"])
def test_a_stamp_that_is_no_time_is_refused(tmp_path, stamp):
    bag = whole_bag(tmp_path / "bag", StoragePlugin.SQLITE3, None, 10)
    (path,) = bag.glob("*.db3")
    with sqlite3.connect(path) as database:
        database.execute(f"UPDATE messages SET timestamp = {stamp}")
    with pytest.raises(ValueError, match=r"bag: .*expected stamps from 0 to 2\*\*63 ns, got "):
        read(bag)


def test_metadata_that_are_too_large_are_refused(tmp_path):
    bag = whole_bag(tmp_path / "bag", StoragePlugin.MCAP, None, 10)
    with (bag / "metadata.yaml").open("a") as file:
        file.write("#" * LARGEST_DOCUMENT)
    with pytest.raises(ValueError, match=r"bag: .*metadata.yaml: expected at most 1048576 bytes"):
        read(bag)


@pytest.mark.parametrize(
    ("plugin", "mode"),
    [
        (StoragePlugin.SQLITE3, CompressionMode.FILE),
        (StoragePlugin.SQLITE3, CompressionMode.MESSAGE),
        (StoragePlugin.MCAP, CompressionMode.STORAGE),
    ],
)
def test_packed_bags_are_refused_when_they_are_bombs_and_read_when_not(tmp_path, plugin, mode):
    assert read(whole_bag(tmp_path / "sound", plugin, mode, 1000, 50)) == 50
    bomb = whole_bag(tmp_path / "bomb", plugin, mode, 2 * LARGEST_PIECE)
    said = in_little_memory(read, bomb)
    assert str(bomb) in said and "bytes unpacked, got more" in said and "\n" not in said


@pytest.mark.parametrize(
    "change",
    [
        "DROP TABLE metadata; CREATE VIRTUAL TABLE metadata USING fts5(x)",
        "ALTER TABLE messages ADD COLUMN more BLOB AS (zeroblob(500000000))",
        "CREATE VIEW message_definitions_2 AS WITH RECURSIVE a(x) AS "
        "(SELECT 1 UNION ALL SELECT x FROM a) SELECT x FROM a",
    ],
)
def test_a_database_that_calculates_is_refused(tmp_path, change):
    bag = whole_bag(tmp_path / "bag", StoragePlugin.SQLITE3, None, 10)
    (path,) = bag.glob("*.db3")
    with sqlite3.connect(path) as database:
        database.executescript(change)
    with pytest.raises(ValueError, match=r"bag: .*expected a database that only stores values"):
        read(bag)


def test_unpacking_gives_what_was_packed_also_of_several_frames():
    data = np.random.default_rng(0).bytes(100_000)
    both = zstandard.compress(data) + zstandard.compress(data)
    assert unpacked(both, "zstd", 200_000) == 2 * data
    assert unpacked(lz4.frame.compress(data), "lz4", 100_000) == data
    assert unpacked(bz2.compress(data) * 2, "bz2", 200_000) == 2 * data
    with pytest.raises(TooLargeBag):
        unpacked(bz2.compress(data), "bz2", 99_999)
    with pytest.raises(TooLargeBag):
        unpacked(both, "zstd", 199_999)
    with pytest.raises(EOFError):
        unpacked(both[:-10], "zstd", 200_000)
    with pytest.raises(ValueError, match="compression zstd, lz4, bz2 or none, got 'br'"):
        unpacked(data, "br")


def test_a_sound_cut_bag_that_is_packed_is_repaired(tmp_path):
    bag = cut_bag(tmp_path / "bag", [1000] * 20, CompressionType.ZSTD)
    assert repair(bag) == 20 and read(bag) == 20
    shutil.rmtree(bag)
