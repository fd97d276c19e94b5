"""One node of a kind on a set of topics: a second one names the first and does not start."""

from __future__ import annotations

import time

from rclpy.node import Node

from softhand_ros.parameters import Parameter

# after which a publisher that was there before has been found; mostly within 0.1 s [s]
DISCOVERY = 0.7
LOOK_PERIOD = 0.02  # wall time between two looks [s]
ALLOW_SECOND = Parameter(
    "allow_second", False, "start although another node of this kind has the same topics"
)


class Single:
    """Whether a node is the only one of its kind. Make it right after the node.

    Args:
        node: that asks.
        kind: of node, as in "another sequencer".
        topic: that every node of the kind publishes, relative to its namespace.
    """

    def __init__(self, node: Node, kind: str, topic: str) -> None:
        self._node, self._kind, self._topic = node, kind, topic
        self._found_by = time.monotonic() + DISCOVERY

    def claim(self, allow_second: bool) -> None:
        """Look for another; call it before the node publishes the topic itself.

        Raises:
            ValueError: there is one, and `allow_second` is False.
        """
        while not allow_second:
            if self._publishers():
                raise ValueError(f"{self._sentence()}, or set {ALLOW_SECOND.name}")
            if time.monotonic() > self._found_by:
                return
            time.sleep(LOOK_PERIOD)

    def warning(self) -> str:
        """What to say while there is another beside this one; empty when it is alone."""
        return self._sentence() if self._publishers() > 1 else ""

    def _publishers(self) -> int:
        return int(self._node.count_publishers(self._topic))

    def _sentence(self) -> str:
        topic = self._node.resolve_topic_name(self._topic)
        return (
            f"another {self._kind} publishes {topic}: end it, or give each a namespace "
            "or a ROS_DOMAIN_ID of its own"
        )
