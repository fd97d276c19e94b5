"""The messages of a bag in the order of reception, and simulated time from its /clock."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
from rosbags.typesys import Stores, get_types_from_msg, get_typestore
from rosbags.typesys.store import Typestore

from model_lab.aliases import IntArray
from model_lab.measurements.bags.limits import AnyReader
from softhand_common.documents.quoted import listed, shortened
from softhand_common.documents.yaml_document import DocumentError

Stamps = IntArray  # [ns], as seconds since 1970 with their nanoseconds do not fit a float
CLOCK = "/clock"


def _types(messages: Path | None) -> Typestore:
    """The message types of ROS 2 Jazzy, and those of a folder of definitions."""
    store = get_typestore(Stores.ROS2_JAZZY)
    if messages is None:
        return store
    files = sorted(messages.rglob("msg/*.msg"))
    if not files:
        raise DocumentError(
            f"{messages}: expected a folder with PACKAGE/msg/NAME.msg, got no such file"
        )
    types: dict[str, Any] = {}
    for file in files:
        name = f"{file.parents[1].name}/msg/{file.stem}"
        try:
            types |= get_types_from_msg(file.read_text(encoding="utf-8"), name)
        # rosbags' parser raises what its grammar happens to raise
        except Exception as reason:
            raise DocumentError(
                f"{file}: expected the definition of a message, got {_said(reason)}"
            ) from reason
    store.register({name: kind for name, kind in types.items() if name not in store.fielddefs})
    return store


@contextmanager
def opened(folder: Path, messages: Path | None = None) -> Iterator[AnyReader]:
    """The reader of a rosbag2 folder or a ROS 1 file, open during the context.

    messages: folder of definitions (PACKAGE/msg/NAME.msg) of types that the bag does not define;
    None: no folder.

    Raises DocumentError for a bag or definitions that cannot be read.
    """
    expected = f"{folder}: expected a rosbag2 folder or a ROS 1 file (.bag)"
    is_ros1 = folder.suffix == ".bag" and folder.is_file()
    if not is_ros1 and not folder.is_dir():
        raise DocumentError(f"{expected}, got {'a file' if folder.exists() else 'nothing there'}")
    if not is_ros1 and not (folder / "metadata.yaml").is_file():
        files = listed(sorted(path.name for path in folder.iterdir()))
        raise DocumentError(
            f"{expected} with metadata.yaml, got {files}; `repair_bag` or `ros2 bag reindex` "
            "repairs a truncated recording"
        )
    types = _types(messages)
    try:
        reader = AnyReader([folder], default_typestore=types)
        reader.open()
    # besides its own errors rosbags raises those of the database or decompression below it
    except Exception as reason:
        raise DocumentError(
            f"{expected}, but its bytes cannot be decoded: {_said(reason)}"
        ) from reason
    try:
        yield reader
    finally:
        reader.close()


class Clock:
    """Simulated time for times of reception, from /clock; without /clock, the times of reception
    themselves.
    """

    def __init__(self, folder: Path, reader: AnyReader) -> None:
        ticks = [
            (received, stamp_of(message.clock))
            for received, message in messages_of(folder, reader, CLOCK)
        ]
        self._received = np.array([received for received, _ in ticks], dtype=np.int64)
        self._time = np.array([time for _, time in ticks], dtype=np.int64)

    def time(self, received: Stamps) -> Stamps:
        """Simulated times (k,) [ns] of wall times of reception (k,) [ns], by the recorded /clock;
        the wall times themselves without one.
        """
        if len(self._received) == 0:
            return received
        since, first = self._received - self._received[0], self._time[0]
        passed = np.interp(received - self._received[0], since, self._time - first)
        return first + passed.round().astype(np.int64)


def messages_of(folder: Path, reader: AnyReader, topic: str) -> Iterator[tuple[int, Any]]:
    """(time of reception [ns], message) of a topic, in the order of reception; raises DocumentError
    for a message that cannot be read.
    """
    connections = [connection for connection in reader.connections if connection.topic == topic]
    if not connections:  # to the reader, an empty list means all
        return
    messages = _read(reader, connections)
    while True:
        try:
            read = next(messages, None)
        # besides its own errors rosbags raises those of database, decompression and bytes below it
        except Exception as reason:
            raise DocumentError(
                f"{folder}: topic {shortened(topic)}: expected messages that can be read, "
                f"got {_said(reason)}"
            ) from reason
        if read is None:
            return
        yield read


def _read(reader: AnyReader, connections: list[Any]) -> Iterator[tuple[int, Any]]:
    for connection, stamp, data in reader.messages(connections=connections):
        yield stamp, reader.deserialize(data, connection.msgtype)


def _said(reason: Exception) -> str:
    return f"{type(reason).__name__}: {shortened(' '.join(str(reason).split()))}"


def stamp_of(stamp: Any) -> int:
    """A ROS time stamp in nanoseconds."""
    return stamp.sec * 1_000_000_000 + stamp.nanosec
