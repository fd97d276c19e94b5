"""rosbags' `AnyReader` with limits: a bag of kilobytes could unpack to gigabytes, or a database in
it could compute messages without end.

The limits take the place of rosbags' own unpacking when this module is imported; bags are read
through it alone.
"""

from __future__ import annotations

import bz2
import sqlite3
import struct
from collections.abc import Collection, Generator, Iterator
from contextlib import closing
from functools import partial
from pathlib import Path
from types import SimpleNamespace
from typing import Any, BinaryIO, cast

import lz4.frame
import rosbags.rosbag1.reader as rosbags_ros1
import rosbags.rosbag2.reader as rosbags_reader
import rosbags.rosbag2.storage_mcap as rosbags_mcap
from rosbags.highlevel import AnyReader
from rosbags.interfaces import Connection
from rosbags.rosbag2.reader import DirectoryReader
from rosbags.rosbag2.storage_mcap import McapReader
from rosbags.rosbag2.storage_sqlite3 import Sqlite3Reader

from softhand_common.documents.quoted import quoted
from softhand_common.documents.yaml_reading import LARGEST_DOCUMENT

__all__ = ["LARGEST_PIECE", "AnyReader", "TooLargeBag", "allowed", "unpacked"]

LARGEST_PIECE = 2**26  # [bytes] of a chunk or a message unpacked; recorders write chunks of 1 MB
# A file may unpack to FREE bytes and RATIO times its own size. Recordings of a hand that stands
# still are packed to a fiftieth; chosen with room, not tuned.
FREE, RATIO = 2**26, 200  # [bytes], [-]
HEAD, CHUNK = struct.Struct("<BQ"), 0x06  # of a record of MCAP: opcode and length; that of a chunk
CALCULATED = """
SELECT name FROM sqlite_master WHERE type = 'view' OR (type = 'table' AND rootpage = 0)
UNION ALL SELECT entry.name FROM sqlite_master entry, pragma_table_xinfo(entry.name) field
WHERE entry.type = 'table' AND entry.rootpage > 0 AND field.hidden != 0
"""  # views, virtual tables and tables with generated columns
ZSTD: Any = rosbags_mcap.zstd


class TooLargeBag(ValueError):
    """A bag that unpacks to more than the limits."""

    def __init__(self, what: str, most: int) -> None:
        super().__init__(f"expected {what} of at most {most} bytes unpacked, got more")


def allowed(size: int) -> int:
    """Number of bytes to which a file of this size [bytes] may unpack in all."""
    return FREE + RATIO * size


def unpacked(data: bytes, compression: str, most: int = LARGEST_PIECE) -> bytes:
    """Unpack compressed data, into at most `most` bytes.

    Args:
        data: the compressed data.
        compression: "zstd", "lz4", "bz2", or "" for none.
        most: limit of the unpacked size [bytes].

    Raises:
        TooLargeBag: the data unpack to more.
        ValueError: an unknown compression.
        ZstdError, RuntimeError: the data are damaged.
    """
    if compression == "":
        return data
    makers = {
        "zstd": ZSTD.ZstdDecompressor,
        "lz4": lz4.frame.LZ4FrameDecompressor,
        "bz2": bz2.BZ2Decompressor,
    }
    if compression not in makers:
        raise ValueError(f"expected the compression zstd, lz4, bz2 or none, got {compression!r}")
    parts: list[bytes] = []
    left = most + 1
    while data and left > 0:
        frame = makers[compression]()
        parts.append(frame.decompress(data, left))
        left -= len(parts[-1])
        if left > 0 and not frame.eof:
            raise EOFError("packed data that are cut off")
        data = frame.unused_data or b""
    if left <= 0:
        raise TooLargeBag("a piece", most)
    return b"".join(parts)


# ---------------------------------------------------------------------- in place of rosbags' own
def _chunk(compression: str) -> Any:
    def unpack(data: bytes, size: int) -> bytes:
        if size > LARGEST_PIECE:
            raise TooLargeBag("a chunk", LARGEST_PIECE)
        return unpacked(data, compression, size)

    return unpack


def _message(data: bytes) -> bytes:
    return unpacked(data, "zstd")


class _File:
    """A packed file that is read up to what it may unpack to."""

    def __init__(self, file: Any, mode: str) -> None:
        self._most = self._left = allowed(Path(file.name).stat().st_size)
        self._file = ZSTD.open(file, mode)

    def read(self, size: int) -> bytes:
        data = cast(bytes, self._file.read(size))
        self._left -= len(data)
        if self._left < 0:
            raise TooLargeBag("a file", self._most)
        return data

    def __enter__(self) -> _File:
        return self

    def __exit__(self, *_: object) -> None:
        self._file.close()


class _CheckedDirectory(DirectoryReader):
    def open(self) -> None:
        """Open; raises ValueError if the metadata are too large, or values in them are not of their
        types.
        """
        if Path(str(self.path), "metadata.yaml").stat().st_size > LARGEST_DOCUMENT:
            raise ValueError(f"metadata.yaml: expected at most {LARGEST_DOCUMENT} bytes, got more")
        super().open()
        self.files = []  # of no use here, and of any kind in damaged metadata
        about = self.metadata
        whole: list[Any] = [about.start_time, about.end_time, about.duration, about.message_count]
        texts: list[Any] = []
        for topic in self.connections:
            whole.append(topic.msgcount)
            texts += [topic.topic, topic.msgtype, topic.digest]
        wrong = [value for value in whole if type(value) is not int or abs(value) > 2**63]
        wrong += [value for value in texts if not isinstance(value, str)]
        if wrong:
            self.close()
            raise ValueError(
                "metadata.yaml: expected times and counts as whole numbers, names and types of "
                f"topics as text, got {quoted(wrong[0])}"
            )

    def messages(
        self, connections: Collection[Connection], start: int | None = None, stop: int | None = None
    ) -> Generator[tuple[Connection, int, bytes], None, None]:
        """The messages; raises TooLargeBag if they are too large together, and ValueError for a
        stamp that ROS cannot have.
        """
        files = [path for path in Path(str(self.path)).iterdir() if path.is_file()]
        most = left = allowed(sum(path.stat().st_size for path in files))
        for message in super().messages(connections, start, stop):
            if type(message[1]) is not int or not 0 <= message[1] < 2**63:
                raise ValueError(f"expected stamps from 0 to 2**63 ns, got {quoted(message[1])}")
            left -= len(message[2])
            if left < 0:
                raise TooLargeBag("messages", most)
            yield message


class _LimitedMcap(McapReader):
    def open(self) -> None:
        """Open; raises TooLargeBag if all chunks together, by the sizes that file or index state,
        are too large. The true size of a chunk is checked when it is unpacked.
        """
        path = Path(str(self.path))
        most = allowed(path.stat().st_size)
        with path.open("rb") as file:
            if sum(_stated_sizes(file)) > most:
                raise TooLargeBag("chunks", most)
        super().open()
        if sum(chunk.uncompressed_size for chunk in self.chunks) > most:
            self.close()
            raise TooLargeBag("chunks", most)


def _stated_sizes(file: BinaryIO) -> Iterator[int]:
    """Sizes [bytes] that chunks state to have unpacked, up to where the file is damaged."""
    file.seek(8)
    while len(head := file.read(HEAD.size)) == HEAD.size:
        opcode, length = HEAD.unpack(head)
        end = file.tell() + length
        if opcode == CHUNK:
            yield int.from_bytes(file.read(24)[16:], "little")
        if end >= 2**63:
            return
        file.seek(end)


class _LimitedSqlite(Sqlite3Reader):
    def open(self) -> None:
        """Open; raises ValueError for a database that computes values instead of storing them, and
        for a topic that occurs twice.
        """
        address = f"{Path(str(self.path)).absolute().as_uri()}?immutable=1"
        with closing(sqlite3.connect(address, uri=True)) as database:
            calculated = database.execute(CALCULATED).fetchone()
            if calculated is not None:
                raise ValueError(
                    "expected a database that only stores values, got one that computes them: "
                    f"{quoted(calculated[0])}"
                )
            twice = "SELECT id FROM topics GROUP BY id HAVING count(*) > 1"
            if (topic := database.execute(twice).fetchone()) is not None:
                raise ValueError(f"expected every topic once, got {quoted(topic[0])} again")
        super().open()


def _limit() -> None:
    packed = {name: partial(unpacked, compression=name) for name in ("bz2", "lz4")}
    rosbags_ros1.decompressors |= packed
    rosbags_mcap.DECOMPRESSORS |= {name: _chunk(name) for name in ("zstd", "lz4")}
    setattr(rosbags_reader, "zstd", SimpleNamespace(open=_File, decompress=_message))  # noqa: B010
    limited = {"mcap": _LimitedMcap, "sqlite3": _LimitedSqlite}
    DirectoryReader.STORAGE_PLUGINS = cast(Any, limited)
    plugins = {"dir": _CheckedDirectory, ".mcap": _LimitedMcap, ".db3": _LimitedSqlite}
    rosbags_reader.Reader.STORAGE_PLUGINS = cast(Any, plugins)


_limit()
