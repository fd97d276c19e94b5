"""The recorder: a process of its own that writes all topics of a domain to a bag.

Works on anything that has the fields of `rclpy.qos.QoSProfile`, so that it needs no ROS.

The recorder's process: `python -m softhand_bringup.ros.recorder <bag folder> [--topics ...]`.

It finds topics as they appear and takes their messages in serialised form straight from the
middleware's queues, fifty times a second. No executor and no wait set: at 2000 messages a second
these would cost more than the recording itself. Stamps are the middleware's own stamps of
reception and of sending, so looking only every 20 ms costs no accuracy.
"""

from __future__ import annotations

import argparse
import importlib
import signal
import sys
import threading
import time
from collections.abc import Collection, Iterable
from pathlib import Path
from typing import Any

import rclpy
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, HistoryPolicy, QoSProfile, ReliabilityPolicy
from rclpy.signals import SignalHandlerOptions
from rosbags.interfaces import (
    Connection,
    Qos,
    QosDurability,
    QosHistory,
    QosLiveliness,
    QosReliability,
    QosTime,
)
from rosbags.rosbag2 import WriterError

from softhand_bringup.bags.writing import BagWriter


def offered_qos(profile: Any) -> Qos:
    """The offered QoS of one publisher as `rosbags` writes it.

    History and depth are not announced by a publisher; a latched topic is given depth 1, any other
    depth 10, so that replaying the bag offers what the suite's nodes offer.
    """
    latched = is_latched(profile)
    return Qos(
        history=QosHistory.KEEP_LAST,
        depth=1 if latched else 10,
        reliability=QosReliability[profile.reliability.name],
        durability=QosDurability[profile.durability.name],
        deadline=_as_time(profile.deadline.nanoseconds),
        lifespan=_as_time(profile.lifespan.nanoseconds),
        liveliness=QosLiveliness[profile.liveliness.name],
        liveliness_lease_duration=_as_time(profile.liveliness_lease_duration.nanoseconds),
        avoid_ros_namespace_conventions=bool(profile.avoid_ros_namespace_conventions),
    )


def is_latched(profile: Any) -> bool:
    """Whether a late subscriber gets the last message of this publisher."""
    return profile.durability.name == "TRANSIENT_LOCAL"


def is_reliable(profile: Any) -> bool:
    """Whether the publisher repeats what was lost."""
    return profile.reliability.name == "RELIABLE"


def common_demand(profiles: Iterable[Any]) -> tuple[bool, bool]:
    """(reliable, latched): the strongest QoS that every one of these publishers satisfies."""
    offered = list(profiles)
    return all(map(is_reliable, offered)), all(map(is_latched, offered))


def _as_time(nanoseconds: int) -> QosTime:
    return QosTime(*divmod(nanoseconds, 10**9))


POLL_PERIOD = 0.02  # [s]
DISCOVERY_PERIOD = 0.1  # [s]
FLUSH_PERIOD = 1.0  # [s]
QUEUE_DEPTH = 2000  # messages of one topic that may wait between two polls
BULKY = ("/hand/markers",)  # 1.6 MB a second of what joint states and pressures tell as well
LAST_MESSAGES = 0.2  # [s] to wait for what is still under way when asked to stop


class Recorder:
    """Subscribes to the topics of the domain but the bulky ones, or to chosen ones, and writes what
    arrives to a bag.
    """

    def __init__(self, node: Node, bag: BagWriter, chosen: Collection[str] = ()) -> None:
        self._node = node
        self._bag = bag
        self._chosen = {f"/{topic.lstrip('/')}" for topic in chosen}
        self._sources: dict[str, tuple[Any, Connection]] = {}
        self._refused: set[str] = set()
        self._diagnostics = node.create_publisher(DiagnosticArray, "/diagnostics", 10)

    def run(self, stopped: threading.Event) -> None:
        """Record until the event is set; then take what is still queued."""
        next_discovery = next_flush = 0.0
        while not stopped.wait(POLL_PERIOD):
            now = time.monotonic()
            if now >= next_discovery:
                self._discover()
                next_discovery = now + DISCOVERY_PERIOD
            self._drain()
            if now >= next_flush:
                self._bag.flush()
                self._report()
                next_flush = now + FLUSH_PERIOD
        time.sleep(LAST_MESSAGES)
        self._drain()

    def _discover(self) -> None:
        for topic, types in self._node.get_topic_names_and_types():
            if topic in self._sources or topic in self._refused:
                continue
            if not is_recorded(topic, self._chosen):
                continue
            publishers = self._node.get_publishers_info_by_topic(topic)
            if publishers:
                self._subscribe(topic, types[0], [info.qos_profile for info in publishers])

    def _subscribe(self, topic: str, type_name: str, profiles: list[QoSProfile]) -> None:
        try:
            message_type = _import_message(type_name)
            offered = [offered_qos(profile) for profile in profiles]
            connection = self._bag.add_topic(topic, type_name, offered)
        except (ImportError, AttributeError, ValueError) as error:
            self._refused.add(topic)
            self._node.get_logger().warning(f"not recorded: {topic}: {error}")
            return
        subscription = self._node.create_subscription(
            message_type, topic, _ignore, _subscription_qos(profiles), raw=True
        )
        self._sources[topic] = (subscription, connection)

    def _drain(self) -> None:
        write = self._bag.write
        for subscription, connection in self._sources.values():
            take, message_type = subscription.handle.take_message, subscription.msg_type
            while (taken := take(message_type, True)) is not None:
                data, stamps = taken
                write(connection, stamps["received_timestamp"], stamps["source_timestamp"], data)

    def _report(self) -> None:
        status = DiagnosticStatus(
            level=DiagnosticStatus.WARN if self._refused else DiagnosticStatus.OK,
            name="recorder",
            message="not recorded: " + ", ".join(sorted(self._refused))
            if self._refused
            else "recording",
            values=[
                KeyValue(key="topics", value=str(len(self._sources))),
                KeyValue(key="messages", value=str(self._bag.message_count)),
            ],
        )
        message = DiagnosticArray(status=[status])
        message.header.stamp = self._node.get_clock().now().to_msg()
        self._diagnostics.publish(message)


def is_recorded(topic: str, chosen: Collection[str]) -> bool:
    """Whether a topic goes into the bag: it is among the chosen ones, or none are and it is not
    bulky.

    >>> is_recorded("/hand/markers", ()), is_recorded("/hand/markers", ("/hand/markers",))
    (False, True)
    """
    return topic in chosen if chosen else topic not in BULKY


def _ignore(_: bytes) -> None:
    """Never called: the messages are taken from the queue, not through an executor."""


def _import_message(type_name: str) -> type:
    package, _, name = type_name.split("/")
    return getattr(importlib.import_module(f"{package}.msg"), name)


def _subscription_qos(profiles: list[QoSProfile]) -> QoSProfile:
    reliable, latched = common_demand(profiles)
    return QoSProfile(
        history=HistoryPolicy.KEEP_LAST,
        depth=QUEUE_DEPTH,
        reliability=ReliabilityPolicy.RELIABLE if reliable else ReliabilityPolicy.BEST_EFFORT,
        durability=DurabilityPolicy.TRANSIENT_LOCAL if latched else DurabilityPolicy.VOLATILE,
    )


def _open_bag(folder: Path) -> BagWriter:
    """Open the bag, or end with one sentence that says why not."""
    try:
        return BagWriter(folder)
    except OSError as error:
        sys.exit(f"recorder: cannot write the bag {folder}: {error.strerror}")
    except WriterError:
        sys.exit(f"recorder: cannot write the bag {folder}: it exists already")


def _record(bag: BagWriter, chosen: Collection[str], stopped: threading.Event) -> None:
    rclpy.init(signal_handler_options=SignalHandlerOptions.NO)
    node = Node("recorder", enable_rosout=False, start_parameter_services=False)
    try:
        Recorder(node, bag, chosen).run(stopped)
    finally:
        node.destroy_node()
        rclpy.try_shutdown()


def main(arguments: list[str] | None = None) -> int:
    """Record until SIGINT or SIGTERM; 0 when the bag was closed in order."""
    parser = argparse.ArgumentParser(prog="recorder", description="Record topics to a bag.")
    parser.add_argument("folder", type=Path, help="the bag's folder, which must not exist yet")
    parser.add_argument(
        "--topics", nargs="+", default=(), help="these alone; else all there are but hand/markers"
    )
    parsed = parser.parse_args(arguments)
    bag = _open_bag(parsed.folder)
    stopped = threading.Event()
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, lambda *_: stopped.set())
    try:
        _record(bag, parsed.topics, stopped)
    finally:
        bag.close()
    print(f"recorder: {bag.message_count} messages", flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
