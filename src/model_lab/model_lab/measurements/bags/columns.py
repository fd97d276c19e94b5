"""Columns of numbers from the topics of a bag, at the time stamps of one of them."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from model_lab.aliases import Array
from model_lab.measurements.bags.fields import MessageField, number_fields
from model_lab.measurements.bags.limits import AnyReader
from model_lab.measurements.bags.messages import Clock, Stamps, messages_of, opened, stamp_of
from softhand_common.documents.quoted import listed, shortened
from softhand_common.documents.yaml_document import DocumentError

PROGRESS_PERIOD = 2000  # messages


@dataclass(frozen=True)
class Source:
    """Where a column comes from: topic and field.

    place: place in the document, for error messages. is_angle: whether the column is an angle, for
    which a component of a quaternion is refused.
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
    """(columns (samples,) at the stamps of the leading column, with `time` [s] from 0; lead: the
    other columns before its first stamp, at equally spaced times below 0, or empty).

    A stamp is that of the header of a message; without one, the time of reception, in simulated
    time if /clock was recorded. Other columns are interpolated linearly; samples outside the time
    that all topics cover are left out. Of messages with the same stamp the last counts.

    Args:
        folder: the rosbag2 folder, or the file of a ROS 1 bag (.bag).
        sources: source of each column, by its name.
        leading: name of the column whose stamps are those of the samples.
        told: called with the share (0 to 1) that is done.

    Raises:
        DocumentError: the bag cannot be read, lacks a topic or field or its messages; a value is
            not finite; stamps fall; topics do not overlap in time.
    """
    by_topic: dict[str, list[str]] = {}
    for column, source in sources.items():
        by_topic.setdefault(source.topic, []).append(column)
    with opened(folder) as reader:
        for columns in by_topic.values():
            _check_topic(folder, reader, sources[columns[0]])
        clock = Clock(folder, reader)
        total = sum(reader.topics[topic].msgcount for topic in by_topic)
        counted = _counted(told, total)
        series = [
            _read_topic(folder, reader, clock, {name: sources[name] for name in columns}, counted)
            for columns in by_topic.values()
        ]
    return _aligned(folder, series, leading)


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


def _read_topic(
    folder: Path,
    reader: AnyReader,
    clock: Clock,
    sources: Mapping[str, Source],
    count: Callable[[], None],
) -> _Series:
    received: list[int] = []
    stamps: list[int] = []
    rows: list[list[float]] = []
    fields = [(source, source.field.value) for source in sources.values()]
    first = next(iter(sources.values()))
    for stamp, message in messages_of(folder, reader, first.topic):
        count()
        received.append(stamp)
        stamps.append(stamp_of(message.header.stamp) if hasattr(message, "header") else 0)
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
                f"{source.place}.field: expected an angle, got {source.field.text}, one of the "
                "four numbers of a quaternion; `model-lab import BAG -o SET` computes the tip "
                "angle from all four"
            )
    except LookupError as reason:
        raise DocumentError(
            f"{source.place}.field: expected a number in every message of {source.topic}, got "
            f"{source.field.text} ({reason}) in message {index + 1}; fields with numbers: "
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
