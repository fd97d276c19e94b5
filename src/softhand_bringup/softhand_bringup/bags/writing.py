"""Writes rosbag2 folders that can be repaired when the writer is killed, and cuts bags into parts.

`rosbags` keeps up to 1 MB of messages in memory and writes the index at the end. Here each chunk is
passed to the operating system when it is closed, and the recorder closes one every second. The bag
of a killed recorder therefore lacks at most one second of messages, and the index, which
`softhand_bringup.bags.repair` restores.
"""

from __future__ import annotations

import struct
from collections.abc import Callable, Collection, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, cast

from rosbags.interfaces import Connection, ConnectionExtRosbag2, Qos
from rosbags.rosbag2 import StoragePlugin, Writer
from rosbags.rosbag2.storage_mcap import McapWriter
from rosbags.typesys import Stores, get_typestore

from model_lab.measurements.bags.limits import AnyReader

if TYPE_CHECKING:
    from rosbags.rosbag2.enums import CompressionMode

METADATA_VERSION: Literal[9] = 9  # of Jazzy
CHUNK_SIZE = 1 << 18  # [bytes]

_MESSAGE_OPCODE = 0x05
_MESSAGE_HEADER = struct.Struct("<BQHIQQ")  # opcode, length, channel, sequence, logged, published
_MESSAGE_OVERHEAD = _MESSAGE_HEADER.size - 9  # opcode and length do not count themselves


class _ChunkedMcap(McapWriter):
    """The MCAP file of a bag in small chunks, named as by `ros2 bag record`."""

    def __init__(self, path: Path, compression: CompressionMode) -> None:
        super().__init__(path, compression)
        named_by_rosbags = self.path
        self.path = path / f"{path.name}_0.mcap"
        named_by_rosbags.rename(self.path)

    def write_message(self, channel: int, logged: int, published: int, data: bytes) -> None:
        """Append one message; both stamps in [ns]."""
        chunk = self.chunk
        self.message_start_time = min(logged, self.message_start_time)
        self.message_end_time = max(logged, self.message_end_time)
        chunk.message_start_time = min(logged, chunk.message_start_time)
        chunk.message_end_time = max(logged, chunk.message_end_time)
        chunk.msgs[channel].append((logged, chunk.bio.tell()))
        self.channel_stats[channel] += 1
        size = _MESSAGE_OVERHEAD + len(data)
        chunk.bio.write(_MESSAGE_HEADER.pack(_MESSAGE_OPCODE, size, channel, 0, logged, published))
        chunk.bio.write(data)

    @property
    def chunk_size(self) -> int:
        """Size of the open chunk [bytes]."""
        return self.chunk.bio.tell()

    def flush(self) -> None:
        """Close the open chunk and pass it to the operating system."""
        if self.chunk.bio.tell():
            self.close_chunk()
        self.bio.flush()


class UnwritableBag(ValueError):
    """Writing to a bag failed; complete chunks on the disk are kept and can be repaired."""

    def __init__(self, folder: Path, reason: OSError, kept: int, count: int) -> None:
        self.reason = reason.strerror
        super().__init__(
            f"{folder}: expected to continue writing, got {reason.strerror}; {kept} of {count} "
            f"messages are kept: `softhand repair-bag {folder}` repairs the bag when there is room "
            "again, with `--out FOLDER` in another folder"
        )


class _Writer(Writer):
    STORAGE_PLUGINS = {StoragePlugin.MCAP: _ChunkedMcap}  # noqa: RUF012 (as in the base class)


class BagWriter:
    """Writes a rosbag2 folder: `<folder>/<folder's name>_0.mcap`, and `metadata.yaml` on close.

    Args:
        folder: the bag; must not exist yet. Missing parents are created.

    Raises:
        OSError: the folder cannot be created.
        UnwritableBag: the bag cannot be written, and is closed then; methods raise it, too.
        rosbags.rosbag2.WriterError: the folder exists.
    """

    def __init__(self, folder: Path) -> None:
        self._folder, self._kept, self._is_open = folder, 0, True
        self._writer = _Writer(folder, version=METADATA_VERSION, storage_plugin=StoragePlugin.MCAP)
        self._writer.open()
        self._storage = cast(_ChunkedMcap, self._writer.storage)
        self._types = get_typestore(Stores.ROS2_JAZZY)
        self.flush()

    @property
    def message_count(self) -> int:
        """Messages written so far."""
        return sum(self._writer.counts.values())

    def knows(self, message_type: str) -> bool:
        """Whether the definition of a message type such as `std_msgs/msg/String` is known."""
        return message_type in self._types.fielddefs

    def add_topic(self, topic: str, message_type: str, offered_qos: Sequence[Qos]) -> Connection:
        """Register a topic with its message definition and the QoS that its publishers offer.

        Raises:
            ValueError: the definition of the message type is not known.
        """
        if not self.knows(message_type):
            raise ValueError(
                f"topic {topic}: expected a type of common_interfaces, got {message_type}"
            )
        return self._writer.add_connection(
            topic, message_type, typestore=self._types, offered_qos_profiles=offered_qos
        )

    def write(self, topic: Connection, logged: int, published: int, data: bytes) -> None:
        """Append one serialised message (CDR); `logged` and `published` are the stamps of reception
        and of sending [ns].
        """
        writer = self._writer
        self._storage.write_message(topic.id, logged, published, data)
        writer.counts[topic.id] += 1
        writer.min_timestamp = min(logged, writer.min_timestamp)
        writer.max_timestamp = max(logged, writer.max_timestamp)
        if self._storage.chunk_size > CHUNK_SIZE:
            self.flush()

    def flush(self) -> None:
        """Pass all messages to the operating system, so that they survive this process."""
        try:
            self._storage.flush()
        except OSError as reason:
            raise self._given_up(reason) from reason
        self._kept = self.message_count

    def close(self) -> None:
        """Write the index and `metadata.yaml`; does nothing after a failure."""
        if not self._is_open:
            return
        self.flush()
        self._is_open = False
        try:
            self._writer.close()
        except OSError as reason:
            raise self._given_up(reason) from reason

    def _given_up(self, reason: OSError) -> UnwritableBag:
        """Close the file after a failure; returns the error to raise."""
        self._is_open = False
        with suppress(OSError):  # what is still buffered fails once more
            self._storage.bio.close()
        (self._folder / "metadata.yaml.tmp").unlink(missing_ok=True)
        return UnwritableBag(self._folder, reason, self._kept, self.message_count)


@dataclass(frozen=True)
class Part:
    """A part to cut out of a bag.

    Args:
        folder: folder of the new bag; must not exist yet.
        keeps: whether the part gets a message, given its topic and the stamp of its header [ns].
    """

    folder: Path
    keeps: Callable[[str, int], bool]


def cut_bag(source: Path, parts: Sequence[Part], topics: Collection[str]) -> None:
    """Write parts of a bag as new bags, with the messages as they were recorded.

    Args:
        source: the bag; it is read once and not changed.
        parts: the parts, which may overlap.
        topics: topics to copy; their messages must have a header.

    Raises:
        ValueError: a topic is not in the bag.
        rosbags.rosbag2.WriterError: the folder of a part exists.
    """
    with AnyReader([source]) as reader:
        connections = [c for c in reader.connections if c.topic in topics]
        missing = sorted(set(topics) - {c.topic for c in connections})
        if missing:
            raise ValueError(f"{source}: expected the topic {missing[0]}, got {_names(reader)}")
        writers = [_PartWriter(part, connections) for part in parts]
        for connection, logged, data in reader.messages(connections=connections):
            nanoseconds = _stamp(reader.deserialize(data, connection.msgtype))
            for writer in writers:
                writer.offer(connection, nanoseconds, logged, bytes(data))
        for writer in writers:
            writer.close()


class _PartWriter:
    """Writes one part."""

    def __init__(self, part: Part, connections: Sequence[Connection]) -> None:
        self._keeps = part.keeps
        self._bag = BagWriter(part.folder)
        self._topics = {
            c.topic: self._bag.add_topic(c.topic, c.msgtype, _offered(c)) for c in connections
        }

    def offer(self, connection: Connection, stamp: int, logged: int, data: bytes) -> None:
        if self._keeps(connection.topic, stamp):
            self._bag.write(self._topics[connection.topic], logged, logged, data)

    def close(self) -> None:
        self._bag.close()


def _stamp(message: Any) -> int:
    return int(message.header.stamp.sec) * 10**9 + int(message.header.stamp.nanosec)


def _offered(connection: Connection) -> Sequence:
    extension = connection.ext
    return extension.offered_qos_profiles if isinstance(extension, ConnectionExtRosbag2) else []


def _names(reader: AnyReader) -> str:
    return ", ".join(sorted(reader.topics)) or "none"
