"""Diagnostics: status reports of a node according to REP-107."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from threading import Event, Thread
from typing import Protocol, Self

from builtin_interfaces.msg import Time
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from rclpy.node import Node
from rclpy.qos import QoSProfile

from softhand_ros.topics import RELIABLE, full_name

REPORT_PERIOD = 1.0  # wall time between reports (REP-107) [s]
OK, WARN, ERROR = 0, 1, 2
PREPARING = "preparing"  # key in the report of a node that is not ready yet
QUOTED = 200  # characters of a quoted text


def cut(text: str) -> str:
    """A text from outside, shortened for the log and for /diagnostics.

    >>> len(cut("x" * 10_000_000))
    200
    """
    return text if len(text) <= QUOTED else f"{text[: QUOTED - 3]}..."


class Status(Protocol):
    """A status to report: name, level of REP-107, sentence, and figures with units."""

    @property
    def name(self) -> str:
        """Name of the part of the node that the status describes; "" for the node itself."""

    @property
    def level(self) -> int:
        """0 OK, 1 warning, 2 error, 3 stale."""

    @property
    def message(self) -> str:
        """A sentence that describes the state."""

    @property
    def values(self) -> Mapping[str, str]:
        """Figures with their units, by name."""


@dataclass(frozen=True)
class Report:
    """A status whose sentence lists errors and warnings, or is `well` when there are none."""

    name: str
    well: str
    warnings: Sequence[str] = ()
    values: Mapping[str, str] = field(default_factory=dict)
    errors: Sequence[str] = ()

    @property
    def level(self) -> int:
        """ERROR when there is an error, else WARN when there is a warning, else OK."""
        return ERROR if any(self.errors) else WARN if any(self.warnings) else OK

    @property
    def message(self) -> str:
        """The errors and the warnings, or `well` when there are none."""
        return "; ".join(filter(None, (*self.errors, *self.warnings))) or self.well


class Diagnostics:
    """A topic of diagnostic arrays.

    Args:
        node: the node that publishes.
        name: name of the node, written before the names of its parts.
        hardware: identifier of the device. `name` and `hardware` get the node's namespace as a
            prefix.
        topic, qos: topic and quality of service of the publisher.
    """

    def __init__(
        self,
        node: Node,
        name: str,
        hardware: str,
        topic: str = "/diagnostics",
        qos: QoSProfile = RELIABLE,
    ) -> None:
        self._node = node
        self._name, self._hardware = full_name(node, name), full_name(node, hardware)
        self._publisher = node.create_publisher(DiagnosticArray, topic, qos)

    def publish(self, reports: Iterable[Status], stamp: Time | None = None) -> None:
        """Publish reports in one message, stamped with the node's time if `stamp` is None."""
        message = DiagnosticArray(status=[self._status(report) for report in reports])
        message.header.stamp = stamp or self._node.get_clock().now().to_msg()
        self._publisher.publish(message)

    def _status(self, report: Status) -> DiagnosticStatus:
        return DiagnosticStatus(
            name=f"{self._name}: {report.name}" if report.name else self._name,
            level=bytes([report.level]),
            message=report.message,
            hardware_id=self._hardware,
            values=[KeyValue(key=key, value=value) for key, value in report.values.items()],
        )


class Preparation:
    """Reports in the log and in /diagnostics why a node is not ready yet; a context manager.

    Call it with a sentence: a thread of its own, as the node's thread is busy, reports the sentence
    once a second until the context ends.

    Args:
        node: the node; its log gets the sentence.
        diagnostics: the node's topic of diagnostics.
        part: name of the part of the node that is being prepared.
    """

    def __init__(self, node: Node, diagnostics: Diagnostics, part: str) -> None:
        self._node, self._diagnostics, self._part = node, diagnostics, part
        self._ready = Event()
        self._thread: Thread | None = None

    def __call__(self, sentence: str) -> None:
        """Begin to report the sentence."""
        self._node.get_logger().info(sentence)
        report = Report(self._part, "", [sentence], {PREPARING: "yes"})

        def publish() -> None:
            self._diagnostics.publish([report])
            while not self._ready.wait(REPORT_PERIOD):
                self._diagnostics.publish([report])

        self._thread = Thread(target=publish, name="preparation")
        self._thread.start()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self._ready.set()
        if self._thread is not None:
            self._thread.join()
