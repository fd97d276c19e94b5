"""Repair of a bag whose recorder was killed: `python -m softhand_bringup.bags.repair <folder>`.

Such a bag has chunks of messages but neither index nor `metadata.yaml`. The messages are read
record by record up to where the file breaks off and written to a new bag, which then takes the
place of the old one, or stands elsewhere with `--out`. Of a chunk that is damaged the records
before the damage are kept; messages whose channel is damaged are left out.
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

import zstandard
from mcap.exceptions import EndOfFile, McapError
from mcap.opcode import Opcode
from mcap.records import Channel, Chunk, McapRecord, Message, Schema
from mcap.stream_reader import StreamReader, get_chunk_data_stream
from rosbags.interfaces import Connection, Qos
from rosbags.rosbag2 import ReaderError, WriterError
from rosbags.rosbag2.metadata import parse_qos

from softhand_bringup.bags.writing import BagWriter, UnwritableBag

MAGIC = b"\x89MCAP0\r\n"
BROKEN = (  # what damaged bytes raise in mcap and in the decompression below it
    McapError,
    struct.error,
    UnicodeDecodeError,
    OverflowError,
    MemoryError,
    RuntimeError,
    zstandard.ZstdError,
)
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
        raise ValueError(f"expected the magic {MAGIC!r}, got {content[:8]!r}")
    types: dict[int, str] = {}
    topics: dict[int, Topic] = {}
    for record in _records(content):
        if isinstance(record, Schema):
            types[record.id] = record.name
        elif isinstance(record, Channel) and record.schema_id in types:
            topics[record.id] = Topic(record.topic, types[record.schema_id], _offered(record))
        elif isinstance(record, Message) and record.channel_id in topics:
            topic = topics[record.channel_id]
            yield Recovered(topic, record.log_time, record.publish_time, record.data)


def _offered(channel: Channel) -> list[Qos]:
    """What its publishers offer, as far as that can be read."""
    try:
        return parse_qos(channel.metadata.get("offered_qos_profiles", ""))
    except (ReaderError, ValueError, LookupError, TypeError, AttributeError):
        return []


def _records(content: bytes) -> Iterator[McapRecord]:
    """Whole records, those inside chunks in place of the chunk."""
    stream, whole = _Whole(content), 0
    try:
        for record in StreamReader(stream, emit_chunks=True).records:
            yield from _of_chunk(record) if isinstance(record, Chunk) else [record]
            whole = stream.tell()
    except BROKEN:
        yield from _of_cut_chunk(content[whole:])


def _of_chunk(chunk: Chunk) -> Iterator[McapRecord]:
    """Records of a chunk up to the first that is damaged."""
    try:
        stream, size = get_chunk_data_stream(chunk)
        yield from StreamReader(_Whole(stream.read(size)), skip_magic=True).records
    except BROKEN:
        return


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


def repair(folder: Path, out: Path | None = None) -> int:
    """Make a cut-off bag whole in place, or as a new bag at `out`; returns how many messages were
    saved.

    A bag that has its `metadata.yaml` is left alone.

    Raises:
        ValueError: the folder holds no MCAP file, or one that cannot be read.
        OSError, UnwritableBag: it cannot be written; then the broken bag is as it was.
        rosbags.rosbag2.WriterError: `out` exists.
    """
    if (folder / "metadata.yaml").exists():
        raise ValueError(f"{folder}: nothing to repair, metadata.yaml is there")
    files = sorted(folder.glob("*.mcap"))
    if len(files) != 1:
        raise ValueError(f"{folder}: expected one .mcap file, got {len(files)}")
    if out is not None:
        return _rewrite(files[0], out)
    workplace = folder / "repair"
    shutil.rmtree(workplace, ignore_errors=True)
    whole = workplace / folder.resolve().name
    try:
        count = _rewrite(files[0], whole)
    except (UnwritableBag, OSError, ValueError):
        shutil.rmtree(workplace, ignore_errors=True)
        raise
    for path in whole.iterdir():
        path.replace(folder / path.name)
    if files[0].name != f"{whole.name}_0.mcap":  # the folder was renamed after recording
        files[0].unlink()
    shutil.rmtree(workplace)
    return count


def _rewrite(broken: Path, whole: Path) -> int:
    with broken.open("rb") as file:
        if file.read(len(MAGIC)) != MAGIC:
            file.seek(0)
            raise ValueError(f"{broken}: expected the magic {MAGIC!r}, got {file.read(8)!r}")
    bag = BagWriter(whole)
    connections: dict[tuple[str, str], Connection] = {}
    for message in recover(broken.read_bytes()):
        topic = message.topic
        key = topic.name, topic.message_type
        if not bag.knows(topic.message_type):
            continue
        if key not in connections:
            connections[key] = bag.add_topic(*key, topic.offered_qos)
        bag.write(connections[key], message.logged, message.published, message.data)
    bag.close()
    return bag.message_count


def main(arguments: list[str] | None = None) -> int:
    """Repair one bag; 0 when it is whole afterwards."""
    words = "Repair a bag whose recorder was killed."
    parser = argparse.ArgumentParser(prog="softhand repair-bag", description=words)
    parser.add_argument("folder", type=Path, help="the bag's folder")
    parser.add_argument(
        "--out", type=Path, help="a new folder for the whole bag, as on another disk"
    )
    options = parser.parse_args(arguments)
    folder, out = options.folder, options.out
    try:
        count = repair(folder, out)
    except UnwritableBag as error:
        return _refuse(
            f"{out or folder}: expected room for the whole bag, got {error.reason}; the broken one "
            "is as it was: give --out FOLDER on another disk"
        )
    except (ValueError, OSError, WriterError) as error:
        return _refuse(str(error))
    print(f"softhand repair-bag: {count} messages saved in {out or folder}")
    return 0


def _refuse(reason: str) -> int:
    print(f"softhand repair-bag: {reason}", file=sys.stderr)
    return 1


if __name__ == "__main__":
    sys.exit(main())
