"""The node `recorder`: writes all topics of a domain, or chosen ones, to a bag.

In a namespace it writes the topics of the namespace and those without any, such as /clock.

It finds new topics and takes their serialised messages directly from the queues of the middleware,
fifty times a second. It has no executor and no wait set: at 2000 messages a second these would cost
more than the recording itself. Stamps are those of the middleware, so that reading the queues only
every 20 ms costs no accuracy.

Where tf2_msgs is not installed nobody publishes `/tf`: then the recorder writes the frames itself.
"""

from __future__ import annotations

import argparse
import importlib
import sys
import threading
import time
from collections.abc import Collection
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, HistoryPolicy, QoSProfile, ReliabilityPolicy
from rclpy.utilities import remove_ros_args
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

from softhand_bringup.bags.frames import TF, FrameWriter
from softhand_bringup.bags.writing import BagWriter, UnwritableBag
from softhand_bringup.processes.suite import RECORDER
from softhand_ros.diagnostics import REPORT_PERIOD, Diagnostics, Report
from softhand_ros.parameters import declare
from softhand_ros.run_node import run_node
from softhand_ros.topics import SECOND_NS, latched, unused

RECORDER_PERIOD = 0.02  # [s]
DISCOVERY_PERIOD = 0.1  # [s]
QUEUE_DEPTH = 2000  # messages of one topic between two polls
BULKY_TOPIC = (
    "/hand/markers"  # of any hand: 1.6 MB/s that can be computed from joint states and pressures
)
LAST_MESSAGES = 0.2  # [s] to wait for the last messages before the end


def offered_qos(profile: QoSProfile) -> Qos:
    """The offered QoS of one publisher as `rosbags` writes it.

    History and depth are not announced by a publisher; a latched topic gets depth 1, any other
    depth 10, so that a replay of the bag offers the same as the suite's nodes.
    """
    latched = profile.durability is DurabilityPolicy.TRANSIENT_LOCAL
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


def _as_time(nanoseconds: int) -> QosTime:
    return QosTime(*divmod(nanoseconds, SECOND_NS))


class Recorder(Node):
    """Subscribes to all topics of the domain except bulky ones, or to chosen ones, and writes their
    messages to a bag. If tf2_msgs is not installed, it also writes the frames of the hands.
    """

    def __init__(self, bag: BagWriter, chosen: Collection[str] = ()) -> None:
        super().__init__(RECORDER, enable_rosout=False, start_parameter_services=False)
        declare(self, ())
        self._bag = bag
        self._chosen = {self.resolve_topic_name(topic) for topic in chosen}
        self._sources: dict[str, tuple[Any, Connection]] = {}
        self._refused: set[str] = set()
        self._frames: FrameWriter | None = None
        if find_spec("tf2_msgs") is None and (not chosen or TF in self._chosen):
            offered = [[offered_qos(qos)] for qos in (QoSProfile(depth=100), latched(1))]
            self._frames = FrameWriter(bag, *offered)
        self._diagnostics = Diagnostics(self, RECORDER, "")
        self.get_logger().info("ready")

    def close(self) -> None:
        """Destroy the node; the caller closes the bag."""
        self.destroy_node()

    def run(self, stopped: threading.Event) -> None:
        """Record until the event is set, then write the messages that are still queued."""
        next_discovery = next_report = 0.0
        while not stopped.wait(RECORDER_PERIOD):
            now = time.monotonic()
            if now >= next_discovery:
                self._discover()
                next_discovery = now + DISCOVERY_PERIOD
            self._drain()
            if now >= next_report:
                self._bag.flush()
                self._report()
                next_report = now + REPORT_PERIOD
        time.sleep(LAST_MESSAGES)
        self._drain()

    def _discover(self) -> None:
        for topic, types in self.get_topic_names_and_types():
            if topic in self._sources or topic in self._refused:
                continue
            if not is_recorded(topic, self._chosen, self.get_namespace()):
                continue
            profiles = self._profiles(topic)
            if profiles:
                self._subscribe(topic, types[0], profiles)

    def _profiles(self, topic: str) -> list[QoSProfile]:
        """QoS profiles that publishers of a topic offer. Without publishers those that subscribers
        request, so that commands are recorded from the first one on; none for a latched topic.
        """
        if publishers := self.get_publishers_info_by_topic(topic):
            return [info.qos_profile for info in publishers]
        asked = [info.qos_profile for info in self.get_subscriptions_info_by_topic(topic)]
        latched = any(p.durability is DurabilityPolicy.TRANSIENT_LOCAL for p in asked)
        return [] if latched else asked

    def _subscribe(self, topic: str, type_name: str, profiles: list[QoSProfile]) -> None:
        try:
            message_type = _import_message(type_name)
            offered = [offered_qos(profile) for profile in profiles]
            connection = self._bag.add_topic(topic, type_name, offered)
        except (ImportError, AttributeError, ValueError) as error:
            self._refused.add(topic)
            self.get_logger().warning(f"not recorded: {topic}: {error}")
            return
        subscription = self.create_subscription(
            message_type, topic, unused, _subscription_qos(profiles), raw=True
        )
        self._sources[topic] = (subscription, connection)

    def _drain(self) -> None:
        write = self._bag.write
        for subscription, connection in self._sources.values():
            take, message_type = subscription.handle.take_message, subscription.msg_type
            while (taken := take(message_type, True)) is not None:
                data, stamps = taken
                when = stamps["received_timestamp"], stamps["source_timestamp"]
                write(connection, *when, data)
                if self._frames is not None:
                    self._frames.take(connection.topic, connection.msgtype, *when, data)

    def _report(self) -> None:
        values = {"topics": str(len(self._sources)), "messages": str(self._bag.message_count)}
        refused = ", ".join(sorted(self._refused))
        no_frames = self._frames.refused if self._frames is not None else ""
        warnings = (
            f"not recorded: {refused}" if refused else "",
            f"no frames for the links of {no_frames}" if no_frames else "",
        )
        self._diagnostics.publish([Report("", "recording", warnings, values)])


def is_recorded(topic: str, chosen: Collection[str], namespace: str = "/") -> bool:
    """Whether a topic is recorded: it is one of the chosen ones; or none are chosen, it is not
    bulky and belongs to no other namespace.

    >>> is_recorded("/hand/markers", ()), is_recorded("/hand/markers", ("/hand/markers",))
    (False, True)
    >>> [is_recorded(t, (), "/left") for t in ("/left/wrist/pose", "/right/wrist/pose", "/clock")]
    [True, False, True]
    """
    if chosen:
        return topic in chosen
    own = topic.startswith(f"{namespace.rstrip('/')}/") or topic.count("/") == 1
    return own and not topic.endswith(BULKY_TOPIC)


def _import_message(type_name: str) -> type:
    package, _, name = type_name.split("/")
    return getattr(importlib.import_module(f"{package}.msg"), name)


def _subscription_qos(profiles: list[QoSProfile]) -> QoSProfile:
    """The strictest QoS that all of these publishers satisfy."""
    reliable = all(p.reliability is ReliabilityPolicy.RELIABLE for p in profiles)
    latched = all(p.durability is DurabilityPolicy.TRANSIENT_LOCAL for p in profiles)
    return QoSProfile(
        history=HistoryPolicy.KEEP_LAST,
        depth=QUEUE_DEPTH,
        reliability=ReliabilityPolicy.RELIABLE if reliable else ReliabilityPolicy.BEST_EFFORT,
        durability=DurabilityPolicy.TRANSIENT_LOCAL if latched else DurabilityPolicy.VOLATILE,
    )


def _open_bag(folder: Path) -> BagWriter:
    """Open the bag, or exit with a message."""
    try:
        return BagWriter(folder)
    except UnwritableBag as error:
        sys.exit(f"recorder: {error}")
    except OSError as error:
        sys.exit(f"recorder: cannot write the bag {folder}: {error.strerror}")
    except WriterError:
        sys.exit(f"recorder: cannot write the bag {folder}: it exists already")


def main(arguments: list[str] | None = None) -> int:
    """Record until SIGINT or SIGTERM; returns 0, or 1 when the bag could not be written, for
    example on a full disk.
    """
    words = sys.argv[1:] if arguments is None else arguments
    parser = argparse.ArgumentParser(
        prog="softhand record",
        description="Record topics to a bag.",
        epilog="Options of ROS follow --ros-args, such as -r __ns:=/left to record the topics "
        "below /left and those without a namespace. The node subscribes to every topic that it "
        "records, writes /tf and /tf_static where tf2_msgs is not installed, publishes "
        "/diagnostics once a second, and has neither services nor parameters.",
    )
    parser.add_argument("folder", type=Path, help="the bag's folder, which must not exist yet")
    parser.add_argument(
        "--topics", nargs="+", default=(), help="topics to record (all but hand/markers)"
    )
    parsed = parser.parse_args(remove_ros_args(words))
    bag = _open_bag(parsed.folder)
    try:
        status = run_node(
            RECORDER,
            lambda: Recorder(bag, parsed.topics),
            Recorder.run,
            args=words,
            failures=(UnwritableBag,),
        )
    finally:
        closed = _close(bag)
    if status == closed == 0:
        print(f"recorder: {bag.message_count} messages", flush=True)
    return status or closed


def _close(bag: BagWriter) -> int:
    """Close the bag; returns 0, or 1 after printing that it cannot be written."""
    try:
        bag.close()
    except UnwritableBag as error:
        print(f"recorder: {error}", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
