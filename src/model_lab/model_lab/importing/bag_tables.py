"""Tables of a bag: a topic each, with the units that ROS gives to the fields of its messages."""

from __future__ import annotations

from pathlib import Path

from model_lab.importing.tables import Column, Table
from model_lab.measurements.bag import TopicTable, read_topics
from softhand_common.documents.yaml_document import DocumentError

FIELD_UNITS = {
    "sensor_msgs/msg/FluidPressure": {"fluid_pressure": "Pa"},
    "sensor_msgs/msg/JointState": {"position": "rad"},
    "geometry_msgs/msg/WrenchStamped": {"wrench.force": "N"},
}  # by message type and beginning of the field
TOPIC_UNITS = {"/pneumaticbox/state": {"effort": "Pa"}}  # of the driver of this suite
PASSED_OVER = ("variance", "covariance")


def read_bag(path: Path, messages: Path | None) -> tuple[Table, ...]:
    """The tables of a bag, whose columns are called "TOPIC FIELD". DocumentError where it has none.

    messages: folder of definitions of message types that the bag does not define.
    """
    tables = tuple(_table(path, topic) for topic in read_topics(path, messages))
    if not tables:
        raise DocumentError(f"{path}: expected topics with numbers, got none")
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
