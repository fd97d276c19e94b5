"""Only one node of each kind on a set of topics: a second one refuses to start."""

from __future__ import annotations

import time

from rclpy.node import Node

from softhand_ros.parameters import Parameter

# wall time after which an existing publisher has been discovered; mostly it takes 0.1 s [s]
DISCOVERY_TIME = 0.7
CLAIM_LOOK_PERIOD = 0.02  # wall time between two checks [s]
ALLOW_SECOND = Parameter(
    "allow_second", False, "start although another node of this kind has the same topics"
)


class Single:
    """Checks that a node is the only one of its kind. Create it right after the node.

    Args:
        node: the node.
        kind: its kind in words, as in "another sequencer".
        topic: the topic that every node of this kind publishes, relative to its namespace.
    """

    def __init__(self, node: Node, kind: str, topic: str) -> None:
        self._node, self._kind, self._topic = node, kind, topic
        self._found_by = time.monotonic() + DISCOVERY_TIME

    def claim(self, allow_second: bool) -> None:
        """Look for another node of this kind; call it before this node publishes the topic.

        Raises:
            ValueError: there is another one and `allow_second` is False.
        """
        while not allow_second:
            if self._publishers():
                raise ValueError(f"{self._sentence()}, or set {ALLOW_SECOND.name}")
            if time.monotonic() > self._found_by:
                return
            time.sleep(CLAIM_LOOK_PERIOD)

    def warning(self) -> str:
        """A warning while another node of this kind runs; empty when there is none."""
        return self._sentence() if self._publishers() > 1 else ""

    def _publishers(self) -> int:
        return int(self._node.count_publishers(self._topic))

    def _sentence(self) -> str:
        topic = self._node.resolve_topic_name(self._topic)
        return (
            f"another {self._kind} publishes {topic}: end it, or give each a namespace "
            "or a ROS_DOMAIN_ID of its own"
        )
