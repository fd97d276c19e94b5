"""Diagnostics: reports of a node as REP-107 asks for them."""

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
PREPARING = "preparing"  # key of a report whose node does not serve yet
QUOTED = 200  # characters of what is quoted from outside


def cut(text: str) -> str:
    """What is quoted from outside, short enough for the log and for /diagnostics.

    >>> len(cut("x" * 10_000_000))
    200
    """
    return text if len(text) <= QUOTED else f"{text[: QUOTED - 3]}..."


class Status(Protocol):
    """What is reported: its name, a level of REP-107, a sentence, and figures with units."""

    @property
    def name(self) -> str:
        """Of the part of the node; "" for the node itself."""

    @property
    def level(self) -> int:
        """0 well, 1 warning, 2 error, 3 stale."""

    @property
    def message(self) -> str:
        """A sentence."""

    @property
    def values(self) -> Mapping[str, str]:
        """Figures by name with unit."""


@dataclass(frozen=True)
class Report:
    """A status with errors and warnings, which are its sentence; without any it is `well`."""

    name: str
    well: str
    warnings: Sequence[str] = ()
    values: Mapping[str, str] = field(default_factory=dict)
    errors: Sequence[str] = ()

    @property
    def level(self) -> int:
        """ERROR when there is an error, WARN when there is a warning."""
        return ERROR if any(self.errors) else WARN if any(self.warnings) else OK

    @property
    def message(self) -> str:
        """The errors and the warnings, else that all is well."""
        return "; ".join(filter(None, (*self.errors, *self.warnings))) or self.well


class Diagnostics:
    """A topic of diagnostic arrays.

    Args:
        node: whose it is.
        name: of the node, before the names of its parts.
        hardware: what the reports are about. Both get the node's namespace in front.
        topic, qos: where they are published.
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
        """Publish reports, with the node's time unless they have a stamp of their own."""
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
    """Tells in the log and in /diagnostics what keeps a node from its work; a context.

    Call it with a sentence: until the context ends a thread reports it once a second, as the
    node's own is busy.

    Args:
        node: whose log it is.
        diagnostics: of the node.
        part: of the node that is prepared.
    """

    def __init__(self, node: Node, diagnostics: Diagnostics, part: str) -> None:
        self._node, self._diagnostics, self._part = node, diagnostics, part
        self._ready = Event()
        self._thread: Thread | None = None

    def __call__(self, sentence: str) -> None:
        """Begin to tell it."""
        self._node.get_logger().info(sentence)
        report = Report(self._part, "", [sentence], {PREPARING: "yes"})

        def tell() -> None:
            self._diagnostics.publish([report])
            while not self._ready.wait(REPORT_PERIOD):
                self._diagnostics.publish([report])

        self._thread = Thread(target=tell, name="preparation")
        self._thread.start()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self._ready.set()
        if self._thread is not None:
            self._thread.join()
