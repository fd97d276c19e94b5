"""Cutting of a bag into parts by the stamps of its messages."""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from rosbags.highlevel import AnyReader
from rosbags.interfaces import Connection, ConnectionExtRosbag2

from softhand_bringup.bags.writing import BagWriter


@dataclass(frozen=True)
class Part:
    """A bag to be made: its folder, which must not exist yet, and which messages it gets.

    keeps: is asked with the topic and the stamp of the message's header [ns].
    """

    folder: Path
    keeps: Callable[[str, int], bool]


def cut_bag(source: Path, parts: Sequence[Part], topics: Collection[str]) -> None:
    """Write parts of a bag as bags of their own, message by message as they were recorded.

    Args:
        source: the bag; it is read once and not changed.
        parts: may overlap.
        topics: whose messages have a header; others are left out.

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
    """One part under way."""

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
