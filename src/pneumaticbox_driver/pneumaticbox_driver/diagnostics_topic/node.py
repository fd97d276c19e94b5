"""Publishes reports on `/diagnostics` (REP-107)."""

from __future__ import annotations

from collections.abc import Sequence

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from rclpy.node import Node

from pneumaticbox_driver.backends.topic.node import RELIABLE
from pneumaticbox_driver.report import Report


class DiagnosticsTopic:
    """The node's part of `/diagnostics`.

    Args:
        node: whose it is.
        hardware: what the reports are about.
    """

    def __init__(self, node: Node, hardware: str) -> None:
        self._node, self._hardware = node, hardware
        self._publisher = node.create_publisher(DiagnosticArray, "/diagnostics", RELIABLE)

    def publish(self, reports: Sequence[Report]) -> None:
        """Publish the reports with the node's time."""
        message = DiagnosticArray(status=[self._status(report) for report in reports])
        message.header.stamp = self._node.get_clock().now().to_msg()
        self._publisher.publish(message)

    def _status(self, report: Report) -> DiagnosticStatus:
        return DiagnosticStatus(
            name=f"pneumaticbox: {report.name}",
            level=bytes([report.level]),
            message=report.message,
            hardware_id=self._hardware,
            values=[KeyValue(key=key, value=value) for key, value in report.values.items()],
        )
