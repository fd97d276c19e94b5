"""Repair of a bag whose recorder was killed: `python -m softhand_bringup.bags.repair <folder>`.

Such a bag has chunks of messages but neither index nor `metadata.yaml`. The messages are read
record by record up to where the file breaks off and written to a new bag, which then takes the
place of the old one.
"""

from __future__ import annotations

import argparse
import shutil
import struct
import sys
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from io import BytesIO
from pathlib import Path

from mcap.exceptions import EndOfFile, InvalidMagic, RecordLengthLimitExceeded
from mcap.opcode import Opcode
from mcap.records import Channel, Chunk, McapRecord, Message, Schema
from mcap.stream_reader import StreamReader, breakup_chunk
from rosbags.interfaces import Connection, Qos
from rosbags.rosbag2.metadata import parse_qos

from softhand_bringup.bags.writing import BagWriter

MAGIC = b"\x89MCAP0\r\n"
BROKEN = (EndOfFile, InvalidMagic, RecordLengthLimitExceeded, struct.error)
CHUNK_HEAD = 9 + 28  # opcode and length; start, end, uncompressed size, checksum [bytes]


@dataclass(frozen=True)
class Topic:
    """One channel of the broken file."""

    name: str
    message_type: str
    offered_qos: list[Qos]


@dataclass(frozen=True)
class Recovered:
    """One message that could be read; stamps in [ns], data in CDR."""

    topic: Topic
    logged: int
    published: int
    data: bytes


class _Whole(BytesIO):
    """Bytes that are read whole or not at all; mcap takes what is left for a record."""

    def read(self, size: int | None = -1) -> bytes:
        data = super().read(size)
        if size is not None and len(data) < size:
            raise EndOfFile
        return data


def recover(content: bytes) -> Iterator[Recovered]:
    """Messages of an MCAP file up to the first record that is not whole.

    Raises:
        ValueError: not an MCAP file.
    """
    if not content.startswith(MAGIC):
        raise ValueError(f"file: expected the magic {MAGIC!r}, got {content[:8]!r}")
    types: dict[int, str] = {}
    topics: dict[int, Topic] = {}
    for record in _records(content):
        if isinstance(record, Schema):
            types[record.id] = record.name
        elif isinstance(record, Channel):
            qos = parse_qos(record.metadata.get("offered_qos_profiles", ""))
            topics[record.id] = Topic(record.topic, types[record.schema_id], qos)
        elif isinstance(record, Message):
            topic = topics[record.channel_id]
            yield Recovered(topic, record.log_time, record.publish_time, record.data)


def _records(content: bytes) -> Iterator[McapRecord]:
    """Whole records, those inside chunks in place of the chunk."""
    stream, whole = _Whole(content), 0
    try:
        for record in StreamReader(stream, emit_chunks=True).records:
            yield from breakup_chunk(record) if isinstance(record, Chunk) else [record]
            whole = stream.tell()
    except BROKEN:
        yield from _of_cut_chunk(content[whole:])


def _of_cut_chunk(content: bytes) -> Iterator[McapRecord]:
    """Whole records at the beginning of a chunk that is broken, unless it is compressed."""
    if content[:1] != bytes([Opcode.CHUNK]) or content[CHUNK_HEAD : CHUNK_HEAD + 4] != bytes(4):
        return
    records: Iterable[McapRecord]
    records = StreamReader(_Whole(content[CHUNK_HEAD + 12 :]), skip_magic=True).records
    try:
        yield from records
    except BROKEN:
        return


def repair(folder: Path) -> int:
    """Make a cut-off bag whole in place; returns the number of messages saved.

    A bag that has its `metadata.yaml` is left alone.

    Raises:
        ValueError: the folder holds no MCAP file, or one that cannot be read.
        OSError: the folder cannot be written.
    """
    if (folder / "metadata.yaml").exists():
        raise ValueError(f"{folder}: nothing to repair, metadata.yaml is there")
    files = sorted(folder.glob("*.mcap"))
    if len(files) != 1:
        raise ValueError(f"{folder}: expected one .mcap file, got {len(files)}")
    workplace = folder / "repair"
    shutil.rmtree(workplace, ignore_errors=True)
    whole = workplace / folder.resolve().name
    count = _rewrite(files[0], whole)
    for path in whole.iterdir():
        path.replace(folder / path.name)
    if files[0].name != f"{whole.name}_0.mcap":  # the folder was renamed after recording
        files[0].unlink()
    shutil.rmtree(workplace)
    return count


def _rewrite(broken: Path, whole: Path) -> int:
    bag = BagWriter(whole)
    connections: dict[str, Connection] = {}
    for message in recover(broken.read_bytes()):
        topic = message.topic
        name = topic.name
        if name not in connections:
            connections[name] = bag.add_topic(name, topic.message_type, topic.offered_qos)
        bag.write(connections[name], message.logged, message.published, message.data)
    bag.close()
    return bag.message_count


def main(arguments: list[str] | None = None) -> int:
    """Repair one bag; 0 when it is whole afterwards."""
    words = "Repair a bag whose recorder was killed."
    parser = argparse.ArgumentParser(prog="softhand repair-bag", description=words)
    parser.add_argument("folder", type=Path, help="the bag's folder")
    folder = parser.parse_args(arguments).folder
    try:
        count = repair(folder)
    except (ValueError, OSError) as error:
        print(f"softhand repair-bag: {error}", file=sys.stderr)
        return 1
    print(f"softhand repair-bag: {count} messages saved in {folder}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
