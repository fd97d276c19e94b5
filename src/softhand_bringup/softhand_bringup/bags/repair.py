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
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from rosbags.interfaces import Connection, Qos
from rosbags.rosbag2.metadata import parse_qos

from softhand_bringup.bags.writing import BagWriter

MAGIC = b"\x89MCAP0\r\n"
_SCHEMA, _CHANNEL, _MESSAGE, _CHUNK, _DATA_END = 0x03, 0x04, 0x05, 0x06, 0x0F
_RECORD_HEADER = struct.Struct("<BQ")
_MESSAGE_FIELDS = struct.Struct("<HIQQ")  # channel, sequence, logged, published
_CHUNK_FIELDS_SIZE = 8 + 8 + 8 + 4  # start, end, uncompressed size, checksum


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


def recover(content: bytes) -> Iterator[Recovered]:
    """Messages of an MCAP file up to the first record that is not whole.

    Args:
        content: the file's bytes, uncompressed chunks (as `BagWriter` writes them).

    Raises:
        ValueError: not an MCAP file, or its chunks are compressed.
    """
    if not content.startswith(MAGIC):
        raise ValueError(f"file: expected the magic {MAGIC!r}, got {content[:8]!r}")
    types: dict[int, str] = {}
    topics: dict[int, Topic] = {}
    for opcode, body in _records(content, len(MAGIC)):
        if opcode == _SCHEMA:
            number, name = _read_schema(body)
            types[number] = name
        elif opcode == _CHANNEL:
            number, topic = _read_channel(body, types)
            topics[number] = topic
        elif opcode == _MESSAGE:
            channel, _, logged, published = _MESSAGE_FIELDS.unpack_from(body)
            data = bytes(body[_MESSAGE_FIELDS.size :])
            yield Recovered(topics[channel], logged, published, data)


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


def _records(content: bytes | memoryview, start: int) -> Iterator[tuple[int, memoryview]]:
    """(opcode, body) of each whole record, those inside chunks in place of the chunk."""
    view, position = memoryview(content), start
    while position + _RECORD_HEADER.size <= len(view):
        opcode, length = _RECORD_HEADER.unpack_from(view, position)
        begin = position + _RECORD_HEADER.size
        position = begin + length
        if opcode == _CHUNK:  # also one that is not whole: its first messages can be read
            yield from _records(*_chunk_content(view[begin:position]))
        elif opcode == _DATA_END or position > len(view):
            return
        else:
            yield opcode, view[begin:position]


def _chunk_content(body: memoryview) -> tuple[memoryview, int]:
    if len(body) < _CHUNK_FIELDS_SIZE + 4:
        return body, len(body)
    compression, position = _read_string(body, _CHUNK_FIELDS_SIZE)
    if compression:
        raise ValueError(f"chunk: expected no compression, got {compression!r}")
    return body, position + 8  # behind the length of the records


def _read_schema(body: memoryview) -> tuple[int, str]:
    name, _ = _read_string(body, 2)
    return struct.unpack_from("<H", body)[0], name


def _read_channel(body: memoryview, types: dict[int, str]) -> tuple[int, Topic]:
    number, schema = struct.unpack_from("<HH", body)
    name, position = _read_string(body, 4)
    _, position = _read_string(body, position)  # the encoding, always CDR here
    position += 4
    qos: list[Qos] = []
    while position < len(body):
        key, position = _read_string(body, position)
        value, position = _read_string(body, position)
        if key == "offered_qos_profiles":
            qos = parse_qos(value)
    return number, Topic(name, types[schema], qos)


def _read_string(body: memoryview, position: int) -> tuple[str, int]:
    (length,) = struct.unpack_from("<I", body, position)
    begin = position + 4
    return bytes(body[begin : begin + length]).decode(), begin + length


def main(arguments: list[str] | None = None) -> int:
    """Repair one bag; 0 when it is whole afterwards."""
    parser = argparse.ArgumentParser(prog="repair_bag", description="Repair a cut-off bag.")
    parser.add_argument("folder", type=Path, help="the bag's folder")
    folder = parser.parse_args(arguments).folder
    try:
        count = repair(folder)
    except (ValueError, OSError) as error:
        print(f"repair_bag: {error}", file=sys.stderr)
        return 1
    print(f"repair_bag: {count} messages saved in {folder}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
