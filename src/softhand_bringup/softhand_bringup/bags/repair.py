"""Repairs a bag whose recorder was killed: `python -m softhand_bringup.bags.repair <folder>`.

Such a bag has chunks of messages but neither index nor `metadata.yaml`. The messages are read
record by record up to where the file breaks off, and written to a new bag, which replaces the old
one, or goes to another place with `--out`. Of a chunk that is damaged the records before the damage
are kept; messages whose channel or stamp is damaged are left out.
"""

from __future__ import annotations

import argparse
import shutil
import struct
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from io import BytesIO
from pathlib import Path

from mcap.exceptions import EndOfFile, McapError
from mcap.opcode import Opcode
from mcap.records import Channel, Chunk, McapRecord, Message, Schema
from mcap.stream_reader import StreamReader
from rosbags.interfaces import Connection, Qos
from rosbags.rosbag2 import ReaderError, WriterError
from rosbags.rosbag2.metadata import parse_qos

from model_lab.measurements.bags.limits import LARGEST_PIECE, ZSTD, TooLargeBag, allowed, unpacked
from softhand_bringup.bags.writing import BagWriter, UnwritableBag

MAGIC = b"\x89MCAP0\r\n"
BROKEN = (  # exceptions of mcap and of the decompression for damaged bytes
    McapError,
    struct.error,
    UnicodeDecodeError,
    OverflowError,
    MemoryError,
    EOFError,
    RuntimeError,
    ZSTD.ZstdError,
)
LATEST = 2**63 - 1  # [ns], of a stamp in ROS
CHUNK_HEAD = 9 + 28  # opcode and length; start, end, uncompressed size, checksum [bytes]


@dataclass(frozen=True)
class Topic:
    """One channel of the damaged file."""

    name: str
    message_type: str
    offered_qos: list[Qos]


@dataclass(frozen=True)
class Recovered:
    """One readable message; stamps in [ns], data in CDR."""

    topic: Topic
    logged: int
    published: int
    data: bytes


class _Whole(BytesIO):
    """Raises EndOfFile when fewer bytes are left than asked for; mcap would parse the rest."""

    def read(self, size: int | None = -1) -> bytes:
        data = super().read(size)
        if size is not None and len(data) < size:
            raise EndOfFile
        return data


def recover(content: bytes) -> Iterator[Recovered]:
    """Messages of an MCAP file up to the first incomplete record.

    Raises:
        ValueError: the content is not an MCAP file.
        TooLargeBag: the unpacked chunks are larger than a bag may be.
    """
    if not content.startswith(MAGIC):
        raise ValueError(f"expected an MCAP file, beginning with {MAGIC!r}, got {content[:8]!r}")
    types: dict[int, str] = {}
    topics: dict[int, Topic] = {}
    for record in _records(content):
        if isinstance(record, Schema):
            types[record.id] = record.name
        elif isinstance(record, Channel) and record.schema_id in types:
            topics[record.id] = Topic(record.topic, types[record.schema_id], _offered(record))
        elif isinstance(record, Message) and record.channel_id in topics:
            topic = topics[record.channel_id]
            if max(record.log_time, record.publish_time) > LATEST:
                continue
            yield Recovered(topic, record.log_time, record.publish_time, record.data)


def _offered(channel: Channel) -> list[Qos]:
    """QoS that the publishers of a channel offered; empty when it cannot be read."""
    try:
        return parse_qos(channel.metadata.get("offered_qos_profiles", ""))
    except (ReaderError, ValueError, LookupError, TypeError, AttributeError):
        return []


def _records(content: bytes) -> Iterator[McapRecord]:
    """Whole records, those inside chunks in place of the chunk."""
    stream, whole, most = _Whole(content), 0, allowed(len(content))
    left = most
    try:
        for record in StreamReader(stream, emit_chunks=True).records:
            if isinstance(record, Chunk):
                data = _unpacked(record)
                left -= len(data)
                if left < 0:
                    raise TooLargeBag("chunks", most)
                yield from _of_chunk(data)
            else:
                yield record
            whole = stream.tell()
    except BROKEN:
        yield from _of_cut_chunk(content[whole:])


def _unpacked(chunk: Chunk) -> bytes:
    """What is in a chunk, whatever size it states; nothing where that cannot be unpacked."""
    try:
        return unpacked(chunk.data, chunk.compression, LARGEST_PIECE)
    except TooLargeBag:
        raise
    except (*BROKEN, ValueError):
        return b""


def _of_chunk(data: bytes) -> Iterator[McapRecord]:
    """Records of a chunk up to the first that is damaged, without chunks within it."""
    try:
        for record in StreamReader(_Whole(data), skip_magic=True, emit_chunks=True).records:
            if not isinstance(record, Chunk):
                yield record
    except BROKEN:
        return


def _of_cut_chunk(content: bytes) -> Iterator[McapRecord]:
    """Complete records at the beginning of a truncated chunk; none if it is compressed."""
    if content[:1] != bytes([Opcode.CHUNK]) or content[CHUNK_HEAD : CHUNK_HEAD + 4] != bytes(4):
        return
    yield from _of_chunk(content[CHUNK_HEAD + 12 :])


def repair(folder: Path, out: Path | None = None) -> int:
    """Repair a truncated bag in place, or as a new bag at `out`; returns the number of recovered
    messages.

    Raises:
        ValueError: the folder holds no MCAP file, or one that cannot be read or unpacks to more
            than a bag may.
        OSError, UnwritableBag: the new bag cannot be written; the broken bag is unchanged then.
        rosbags.rosbag2.WriterError: `out` exists.
    """
    if (folder / "metadata.yaml").exists():
        raise ValueError(
            f"{folder}: expected a bag without metadata.yaml, got one that needs no repair"
        )
    files = sorted(folder.glob("*.mcap"))
    if len(files) != 1:
        raise ValueError(f"{folder}: expected one .mcap file, got {len(files)}")
    if out is not None:
        try:
            return _rewrite(files[0], out)
        except TooLargeBag:
            shutil.rmtree(out, ignore_errors=True)
            raise
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
            raise ValueError(
                f"{broken}: expected an MCAP file, beginning with {MAGIC!r}, got {file.read(8)!r}"
            )
    bag = BagWriter(whole)
    connections: dict[tuple[str, str], Connection] = {}
    for message in _named(broken):
        topic = message.topic
        key = topic.name, topic.message_type
        if not bag.knows(topic.message_type):
            continue
        if key not in connections:
            connections[key] = bag.add_topic(*key, topic.offered_qos)
        bag.write(connections[key], message.logged, message.published, message.data)
    bag.close()
    return bag.message_count


def _named(broken: Path) -> Iterator[Recovered]:
    """Messages of a file, which a refusal names."""
    try:
        yield from recover(broken.read_bytes())
    except TooLargeBag as reason:
        reason.args = (f"{broken}: {reason}",)
        raise


def main(arguments: list[str] | None = None) -> int:
    """Repair one bag; returns 0 when that succeeded, else 1."""
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
            f"{out or folder}: expected room for the repaired bag, got {error.reason}; the damaged "
            "one is unchanged: give --out FOLDER on another disk"
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
