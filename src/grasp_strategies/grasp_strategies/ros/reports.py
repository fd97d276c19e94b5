"""The latest diagnostics of simulator and driver."""

from __future__ import annotations

import time

from diagnostic_msgs.msg import DiagnosticArray
from rclpy.node import Node

from grasp_strategies.ros.messages import NodeReport, read_report
from softhand_ros.topics import full_name

SIMULATOR, DRIVER = "hand_sim", "driver"
# by who publishes what is missing: name in /diagnostics, and in a sentence
REPORTERS = {SIMULATOR: ("hand_sim", "the simulator"), DRIVER: ("pneumaticbox", "the driver")}
FAULT_MEMORY = 2.5  # [s] of wall time after which a fault that is not taken back stands


class Reports:
    """The latest report of each node, by source: SIMULATOR or DRIVER.

    Args:
        node: the sequencer's node, whose namespace simulator and driver share.
    """

    def __init__(self, node: Node) -> None:
        self.names = {source: full_name(node, name) for source, (name, _) in REPORTERS.items()}
        self._last: dict[str, NodeReport] = {}

    def receive(self, message: DiagnosticArray) -> None:
        """Store the reports in a message."""
        for source, name in self.names.items():
            report = read_report(message, name, time.monotonic())
            if report is not None:
                self._last[source] = report

    @property
    def fault(self) -> str:
        """Faults that simulator and driver report; empty when there is none."""
        reports = ((who, self._last.get(source)) for source, (_, who) in REPORTERS.items())
        return "; ".join(f"{who} reports: {r.fault}" for who, r in reports if r and r.fault)

    @property
    def preparing(self) -> bool:
        """Whether simulator or driver has recently reported that it is still starting up."""
        return any(report.preparing for report in filter(None, map(self._recent, REPORTERS)))

    def reason(self, source: str) -> str:
        """Why a topic or service of a node is missing: its own report, or else a question such as
        whether it runs.
        """
        report = self._recent(source)
        if report is None:
            return f"is {source} running, and not paused?"
        return f"{source} reports: {report.worst}"

    def _recent(self, source: str) -> NodeReport | None:
        report = self._last.get(source)
        recent = report is not None and time.monotonic() - report.received_at < FAULT_MEMORY
        return report if recent else None
