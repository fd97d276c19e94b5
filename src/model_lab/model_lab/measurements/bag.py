"""Columns of numbers from a rosbag2 folder (MCAP or sqlite3) or a ROS 1 bag, read without ROS."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, fields, is_dataclass
from itertools import islice
from pathlib import Path
from typing import Any

import numpy as np
from rosbags.typesys import Stores, get_types_from_msg, get_typestore
from rosbags.typesys.store import Typestore

from model_lab.aliases import Array, IntArray
from model_lab.measurements.bag_limits import AnyReader
from softhand_common.documents.quoted import listed, quoted, shortened
from softhand_common.documents.yaml_document import DocumentError

SHOWN_FIELDS = 24  # of those a message has, in an error
_STEP = re.compile(r"\.?([A-Za-z_]\w*)|\[([^\[\]]+)\]")
Stamps = IntArray  # [ns], as seconds since 1970 with their nanoseconds do not fit a float
PROGRESS_PERIOD = 2000  # messages
CLOCK = "/clock"
LARGEST_MESSAGE = 64  # numbers of a message that becomes columns; images and clouds have more


@dataclass(frozen=True)
class MessageField:
    """The path of a number in a message.

    `[key]` selects an element of an array by the name that the message's field `name` gives it, as
    in a JointState, else by its index from 0.
    """

    text: str
    steps: tuple[tuple[str, bool], ...]  # (name or key, whether it is a key)

    @classmethod
    def parse(cls, text: str) -> MessageField:
        """The field that a text names; ValueError (expected, got) when it names none."""
        steps: list[tuple[str, bool]] = []
        place = 0
        while place < len(text) or not steps:
            step = _STEP.match(text, place)
            if step is None or (place == 0 and not step.group(1)):
                raise ValueError(
                    f"expected a field such as effort[a] or pose.x, got {quoted(text)}"
                )
            steps.append((step.group(1) or step.group(2), step.group(1) is None))
            place = step.end()
        return cls(text, tuple(steps))

    def value(self, message: Any) -> float:
        """The number (its unit is the message's); LookupError when the message has none there."""
        value = _walked(message, self.steps)
        if not isinstance(value, int | float | np.number | np.bool_):
            raise LookupError("no single number")
        return float(value)

    def is_of_quaternion(self, message: Any) -> bool:
        """Whether the number is a component of a quaternion; LookupError when it is not there."""
        holder = _walked(message, self.steps[:-1])
        return str(getattr(holder, "__msgtype__", "")).endswith("/Quaternion")


def _walked(message: Any, steps: Sequence[tuple[str, bool]]) -> Any:
    """What stands in a message after some steps of a field."""
    holder = value = message
    for name, is_key in steps:
        if is_key:
            value = value[_index(holder, name, len(value))]
        else:
            holder, value = value, getattr(value, name, None)
        if value is None:
            raise LookupError(f"no {name}")
    return value


def number_fields(message: Any) -> list[str]:
    """Fields of a message that hold a number, as they are written, at most SHOWN_FIELDS."""
    shown: list[str] = []
    for text in _fields(message, ""):
        if len(shown) == SHOWN_FIELDS:
            return [*shown, "..."]
        shown.append(text)
    return shown


def _index(holder: Any, key: str, length: int) -> int:
    names = list(getattr(holder, "name", ()))
    if key in names:
        index = names.index(key)
    elif key.isdecimal():
        index = int(key)
    else:
        raise LookupError(f"no {key}")
    if index >= length:
        raise LookupError(f"{length} values")
    return index


def _fields(message: Any, prefix: str) -> Iterator[str]:
    for entry in fields(message):
        value = getattr(message, entry.name)
        path = prefix + entry.name
        if entry.name in ("header", "name", "__msgtype__") or isinstance(value, str):
            continue
        if is_dataclass(value):
            yield from _fields(value, path + ".")
        elif isinstance(value, list | np.ndarray):
            yield from _elements(message, path, value)
        else:
            yield path


def _elements(message: Any, path: str, values: Any) -> Iterator[str]:
    names = list(getattr(message, "name", ()))
    for index, value in enumerate(values):
        element = f"{path}[{names[index] if index < len(names) else index}]"
        if is_dataclass(value):
            yield from _fields(value, element + ".")
        elif not isinstance(value, str):
            yield element


@dataclass(frozen=True)
class Source:
    """Where a column comes from: topic and field, its place in the document for errors, and whether
    it is an angle, which no component of a quaternion is.
    """

    topic: str
    field: MessageField
    place: str
    is_angle: bool = False


@dataclass(frozen=True)
class _Series:
    """Rising stamps (k,) [ns] of a topic and its columns (k,) by name."""

    stamps: Stamps
    columns: Mapping[str, Array]


def read_bag_columns(
    folder: Path, sources: Mapping[str, Source], leading: str, told: Callable[[float], None]
) -> tuple[dict[str, Array], dict[str, Array]]:
    """Columns (samples,) of a bag at the stamps of the leading column, with `time` [s] from 0; and
    the other columns before the first of them, at times below 0 as far apart, or nothing.

    A stamp is that of the message's header, else the time of reception, which /clock turns into
    simulated time if it was recorded. Other columns are interpolated linearly; samples outside the
    time that all topics cover are left out. Of messages with the same stamp the last counts.

    Args:
        folder: the rosbag2 folder, or the file of a ROS 1 bag (.bag).
        sources: by column.
        leading: the column at whose stamps the samples lie.
        told: called with the part that is done.

    Raises:
        DocumentError: the bag cannot be read, lacks a topic or field or its messages; a value is
            not finite; stamps fall; topics do not overlap in time.
    """
    by_topic: dict[str, list[str]] = {}
    for column, source in sources.items():
        by_topic.setdefault(source.topic, []).append(column)
    with _opened(folder) as reader:
        for columns in by_topic.values():
            _check_topic(folder, reader, sources[columns[0]])
        clock = _Clock(folder, reader)
        total = sum(reader.topics[topic].msgcount for topic in by_topic)
        counted = _counted(told, total)
        series = [
            _read_topic(folder, reader, clock, {name: sources[name] for name in columns}, counted)
            for columns in by_topic.values()
        ]
    return _aligned(folder, series, leading)


@dataclass(frozen=True)
class TopicTable:
    """The numbers of a topic: type of its messages, times (k,) [s] since the first message of the
    bag, and columns (k,) by field, NaN where a message lacks one.
    """

    topic: str
    message_type: str
    time: Array
    columns: Mapping[str, Array]


def read_topics(bag: Path, messages: Path | None = None) -> list[TopicTable]:
    """The topics of a bag whose messages hold at most LARGEST_MESSAGE numbers.

    Args:
        bag: a rosbag2 folder or the file of a ROS 1 bag.
        messages: folder of definitions (PACKAGE/msg/NAME.msg) for a bag that has none of its own.

    Raises DocumentError for what cannot be read.
    """
    found = []
    with _opened(bag, messages) as reader:
        clock = _Clock(bag, reader)
        for topic in sorted(set(reader.topics) - {CLOCK}):
            series = _numbers(bag, reader, clock, topic)
            if series is not None:
                found.append((topic, reader.topics[topic].msgtype or "", *series))
    first = min((stamps[0] for _, _, stamps, _ in found), default=0)
    return [
        TopicTable(topic, kind, 1e-9 * (stamps - first), columns)
        for topic, kind, stamps, columns in found
    ]


def _numbers(
    bag: Path, reader: AnyReader, clock: _Clock, topic: str
) -> tuple[Stamps, dict[str, Array]] | None:
    """Stamps (k,) and numbers of a topic; None where it holds none, or too many."""
    fields: list[MessageField] = []
    received: list[int] = []
    stamps: list[int] = []
    rows: list[list[float]] = []
    for stamp, message in _all(bag, reader, topic):
        if not rows:
            texts = list(islice(_fields(message, ""), LARGEST_MESSAGE + 1))
            if not 0 < len(texts) <= LARGEST_MESSAGE:
                return None
            fields = [MessageField.parse(text) for text in texts]
        received.append(stamp)
        stamps.append(_stamp(message.header.stamp) if hasattr(message, "header") else 0)
        rows.append([_number_or_nan(field, message) for field in fields])
    if not rows:
        return None
    time = np.array(stamps, dtype=np.int64)
    if not time.any():
        time = clock.time(np.array(received, dtype=np.int64))
    return time, dict(zip((field.text for field in fields), np.array(rows).T, strict=True))


def _number_or_nan(field: MessageField, message: Any) -> float:
    try:
        return field.value(message)
    except LookupError:
        return np.nan


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
def _opened(folder: Path, messages: Path | None = None) -> Iterator[AnyReader]:
    expected = f"{folder}: expected a rosbag2 folder or a ROS 1 file (.bag)"
    is_ros1 = folder.suffix == ".bag" and folder.is_file()
    if not is_ros1 and not folder.is_dir():
        raise DocumentError(f"{expected}, got {'a file' if folder.exists() else 'nothing there'}")
    if not is_ros1 and not (folder / "metadata.yaml").is_file():
        files = listed(sorted(path.name for path in folder.iterdir()))
        raise DocumentError(
            f"{expected} with metadata.yaml, got {files}; `repair_bag` or `ros2 bag reindex` mends "
            "a recording that was cut off"
        )
    types = _types(messages)
    try:
        reader = AnyReader([folder], default_typestore=types)
        reader.open()
    # besides its own errors rosbags raises those of the database or decompression below it
    except Exception as reason:
        raise DocumentError(f"{expected}, got one that cannot be read: {_said(reason)}") from reason
    try:
        yield reader
    finally:
        reader.close()


def _check_topic(folder: Path, reader: AnyReader, source: Source) -> None:
    topics = {name: topic.msgcount for name, topic in reader.topics.items()}
    if source.topic not in topics:
        raise DocumentError(
            f"{source.place}.topic: expected a topic of the bag {folder}, "
            f"got {shortened(source.topic)}; it holds {listed(sorted(topics))}"
        )
    if topics[source.topic] == 0:
        raise DocumentError(
            f"{source.place}.topic: expected messages on {source.topic} in the bag {folder}, "
            "got none; check that its publisher ran while the bag was recorded"
        )


def _counted(told: Callable[[float], None], total: int) -> Callable[[], None]:
    """A function to call for every message, which now and then tells the part that is done."""
    done = 0

    def count() -> None:
        nonlocal done
        done += 1
        if done % PROGRESS_PERIOD == 0:
            told(done / total)

    return count


class _Clock:
    """Simulated time of stamps of reception, from /clock; the stamps themselves without it."""

    def __init__(self, folder: Path, reader: AnyReader) -> None:
        ticks = [
            (received, _stamp(message.clock)) for received, message in _all(folder, reader, CLOCK)
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


def _all(folder: Path, reader: AnyReader, topic: str) -> Iterator[tuple[int, Any]]:
    """(stamp of reception [ns], message) of a topic, in the order of reception; DocumentError for
    what cannot be read.
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


def _stamp(stamp: Any) -> int:
    return stamp.sec * 1_000_000_000 + stamp.nanosec


def _read_topic(
    folder: Path,
    reader: AnyReader,
    clock: _Clock,
    sources: Mapping[str, Source],
    count: Callable[[], None],
) -> _Series:
    received: list[int] = []
    stamps: list[int] = []
    rows: list[list[float]] = []
    fields = [(source, source.field.value) for source in sources.values()]
    first = next(iter(sources.values()))
    for stamp, message in _all(folder, reader, first.topic):
        count()
        received.append(stamp)
        stamps.append(_stamp(message.header.stamp) if hasattr(message, "header") else 0)
        rows.append([_value(source, read, message, len(rows)) for source, read in fields])
    if not rows:  # although the index counts some
        topic = shortened(first.topic)
        raise DocumentError(f"{folder}: topic {topic}: expected messages to read, got none")
    time = np.array(stamps, dtype=np.int64)
    if not time.any():  # no header, or one that was never filled in
        time = clock.time(np.array(received, dtype=np.int64))
    return _rising(folder, first.topic, time, dict(zip(sources, np.array(rows).T, strict=True)))


def _value(source: Source, read: Callable[[Any], float], message: Any, index: int) -> float:
    try:
        value = read(message)
        if index == 0 and source.is_angle and source.field.is_of_quaternion(message):
            raise DocumentError(
                f"{source.place}.field: expected an angle, got {source.field.text}, a component of "
                "a quaternion: the sine or cosine of half an angle; `model-lab import` makes the "
                "tip angle of the whole quaternion"
            )
    except LookupError as reason:
        raise DocumentError(
            f"{source.place}.field: expected a number in every message of {source.topic}, got "
            f"{source.field.text} ({reason}) in message {index + 1}; it holds "
            f"{', '.join(number_fields(message)) or 'no numbers'}"
        ) from reason
    if not np.isfinite(value):
        raise DocumentError(
            f"{source.place}.field: expected finite numbers, got {value} in message {index + 1} "
            f"of {source.topic}"
        )
    return value


def _rising(folder: Path, topic: str, stamps: Stamps, columns: Mapping[str, Array]) -> _Series:
    """The series without repeated stamps; DocumentError where they fall."""
    steps = np.diff(stamps)
    if np.any(steps < 0):
        index = int(np.argmax(steps < 0)) + 1
        before, after = (f"{stamp * 1e-9:.6f} s" for stamp in stamps[index - 1 : index + 1])
        raise DocumentError(
            f"{folder}: topic {topic}: expected rising stamps, got {after} after {before} in "
            f"message {index + 1}; record one run in one bag, without resetting the clock"
        )
    last = np.append(steps > 0, True)
    return _Series(stamps[last], {name: column[last] for name, column in columns.items()})


def _aligned(
    folder: Path, series: Sequence[_Series], leading: str
) -> tuple[dict[str, Array], dict[str, Array]]:
    lead = next(one for one in series if leading in one.columns)
    start = max(one.stamps[0] for one in series)
    stop = min(one.stamps[-1] for one in series)
    inside = (lead.stamps >= start) & (lead.stamps <= stop)
    if not inside.any():
        spans = ", ".join(
            f"{' and '.join(one.columns)} from "
            f"{one.stamps[0] * 1e-9:.3f} to {one.stamps[-1] * 1e-9:.3f} s"
            for one in series
        )
        raise DocumentError(
            f"{folder}: expected topics that overlap in time, got {spans}; give all of them "
            "header stamps of one clock"
        )
    time = lead.stamps[inside]
    columns = {"time": 1e-9 * (time - time[0])}
    for one in series:
        for name, values in one.columns.items():
            columns[name] = values[inside] if one is lead else _at(time, one, values)
    return columns, _before(time, [one for one in series if one is not lead])


def _before(time: Stamps, others: Sequence[_Series]) -> dict[str, Array]:
    """Columns of other topics before the first of the stamps (samples,), spaced as they are."""
    first = max((one.stamps[0] for one in others), default=time[0])
    period = int(np.median(np.diff(time))) if len(time) > 1 else 0
    count = int((time[0] - first) // period) if period > 0 else 0
    if count == 0:
        return {}
    earlier = time[0] - period * np.arange(count, 0, -1)
    columns = {"time": 1e-9 * (earlier - time[0])}
    for one in others:
        columns |= {name: _at(earlier, one, values) for name, values in one.columns.items()}
    return columns


def _at(time: Stamps, series: _Series, values: Array) -> Array:
    """Values (k,) of a series interpolated at stamps (samples,)."""
    first = series.stamps[0]
    return np.interp(time - first, series.stamps - first, values)
