"""Tables of a bag, one for each topic, with the units that ROS defines for the fields of
messages.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import islice
from pathlib import Path
from typing import Any

import numpy as np

from model_lab.aliases import Array
from model_lab.importing.tables import Column, Table
from model_lab.measurements.bags.fields import MessageField, fields_of
from model_lab.measurements.bags.limits import AnyReader
from model_lab.measurements.bags.messages import (
    CLOCK,
    Clock,
    Stamps,
    messages_of,
    opened,
    stamp_of,
)
from softhand_common.documents.yaml_document import DocumentError

FIELD_UNITS = {
    "sensor_msgs/msg/FluidPressure": {"fluid_pressure": "Pa"},
    "sensor_msgs/msg/JointState": {"position": "rad"},
    "geometry_msgs/msg/WrenchStamped": {"wrench.force": "N"},
}  # by message type and beginning of the field
TOPIC_UNITS = {"/pneumaticbox/state": {"effort": "Pa"}}  # of the driver of this suite
PASSED_OVER = ("variance", "covariance")
LARGEST_MESSAGE = 64  # numbers of a message that becomes columns; images and clouds have more


def read_bag(path: Path, messages: Path | None) -> tuple[Table, ...]:
    """The tables of a bag; columns are called "TOPIC FIELD".

    messages: folder of definitions of message types that the bag does not define; None: no folder.
    Raises DocumentError for a bag without numbers.
    """
    tables = tuple(_table(path, topic) for topic in read_topics(path, messages))
    if not tables:
        raise DocumentError(
            f"{path}: expected a bag with numbers in its messages, got no topic with numbers"
        )
    return tables


def _table(path: Path, topic: TopicTable) -> Table:
    units = FIELD_UNITS.get(topic.message_type, {}) | TOPIC_UNITS.get(topic.topic, {})
    columns = [
        Column(f"{topic.topic} {field}", _unit(units, field), values)
        for field, values in topic.columns.items()
        if not field.startswith(PASSED_OVER)
    ]
    return Table(path, (Column("time", "s", topic.time), *columns))


def _unit(units: dict[str, str], field: str) -> str:
    return next((unit for start, unit in units.items() if field.startswith(start)), "")


@dataclass(frozen=True)
class TopicTable:
    """The numbers in the messages of a topic.

    time (k,) [s]: since the first message of the bag. columns (k,): by field; NaN where a message
    lacks the field.
    """

    topic: str
    message_type: str
    time: Array
    columns: Mapping[str, Array]


def read_topics(bag: Path, messages: Path | None = None) -> list[TopicTable]:
    """The topics of a bag, except those whose messages hold more than LARGEST_MESSAGE numbers.

    Args:
        bag: a rosbag2 folder or the file of a ROS 1 bag.
        messages: folder of definitions (PACKAGE/msg/NAME.msg) for a bag that has none of its own;
            None: no folder.

    Raises DocumentError for a bag that cannot be read.
    """
    found = []
    with opened(bag, messages) as reader:
        clock = Clock(bag, reader)
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
    bag: Path, reader: AnyReader, clock: Clock, topic: str
) -> tuple[Stamps, dict[str, Array]] | None:
    """Stamps (k,) and numbers of a topic; None where it holds none, or too many."""
    fields: list[MessageField] = []
    received: list[int] = []
    stamps: list[int] = []
    rows: list[list[float]] = []
    for stamp, message in messages_of(bag, reader, topic):
        if not rows:
            texts = list(islice(fields_of(message), LARGEST_MESSAGE + 1))
            if not 0 < len(texts) <= LARGEST_MESSAGE:
                return None
            fields = [MessageField.parse(text) for text in texts]
        received.append(stamp)
        stamps.append(stamp_of(message.header.stamp) if hasattr(message, "header") else 0)
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
