"""What simulator and driver say of themselves in /diagnostics."""

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
    """The last report of each, by who publishes what: SIMULATOR or DRIVER.

    Args:
        node: in whose namespace they are.
    """

    def __init__(self, node: Node) -> None:
        self.names = {source: full_name(node, name) for source, (name, _) in REPORTERS.items()}
        self._last: dict[str, NodeReport] = {}

    def hear(self, message: DiagnosticArray) -> None:
        """Keep what a message has of them."""
        for source, name in self.names.items():
            report = read_report(message, name, time.monotonic())
            if report is not None:
                self._last[source] = report

    @property
    def fault(self) -> str:
        """Why they do not do their work; empty when all is well."""
        told = ((who, self._last.get(source)) for source, (_, who) in REPORTERS.items())
        return "; ".join(f"{who} reports: {r.fault}" for who, r in told if r and r.fault)

    @property
    def preparing(self) -> bool:
        """Whether one of them has said of late that it is not at work yet."""
        return any(report.preparing for report in filter(None, map(self._recent, REPORTERS)))

    def reason(self, source: str) -> str:
        """Why something of a node is missing: what it says of itself, or a guess."""
        report = self._recent(source)
        if report is None:
            return f"is {source} running, and not paused?"
        return f"{source} reports: {report.worst}"

    def _recent(self, source: str) -> NodeReport | None:
        report = self._last.get(source)
        recent = report is not None and time.monotonic() - report.heard < FAULT_MEMORY
        return report if recent else None
