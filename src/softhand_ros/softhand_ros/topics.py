"""Topics: quality of service, stamps, and subscriptions whose owner takes the messages itself."""

from __future__ import annotations

from typing import Any

from builtin_interfaces.msg import Time
from rclpy.callback_groups import CallbackGroup
from rclpy.clock import Clock, ClockType
from rclpy.impl.implementation_singleton import rclpy_implementation
from rclpy.node import Node
from rclpy.publisher import Publisher
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from rclpy.subscription import Subscription
from rosgraph_msgs.msg import Clock as Tick

SECOND = 10**9  # [ns]
RELIABLE = QoSProfile(depth=10, reliability=ReliabilityPolicy.RELIABLE)
# /clock of any publisher. For messages of a fixed size alone: of a large one whose rest got lost, a
# best-effort reader of Fast DDS keeps what came, for ever once its publisher has gone
NEWEST = QoSProfile(depth=1, reliability=ReliabilityPolicy.BEST_EFFORT)
TICKS = QoSProfile(depth=50, reliability=ReliabilityPolicy.BEST_EFFORT)
# for who needs the message of a certain instant
LATEST = QoSProfile(depth=50, reliability=ReliabilityPolicy.RELIABLE)


def latched(depth: int) -> QoSProfile:
    """Quality of service of a topic whose last `depth` messages reach late subscribers too."""
    return QoSProfile(
        depth=depth,
        reliability=ReliabilityPolicy.RELIABLE,
        durability=DurabilityPolicy.TRANSIENT_LOCAL,
    )


def full_name(node: Node, name: str) -> str:
    """A name of a frame, a part or another node in the namespace of `node`, as in `left/wrist`."""
    return f"{node.get_namespace()}/{name}".strip("/")


def clock_conflict(node: Node) -> str:
    """What to say when several nodes publish /clock; empty when all is well."""
    count = node.count_publishers("/clock")
    if count < 2:
        return ""
    told = "two" if count == 2 else count
    return f"{told} nodes publish /clock: start all but one with publish_clock:=false"


def refuse_time_before_zero(node: Node) -> None:
    """Have `node` refuse a tick of /clock before 0, at which rclpy raises: it would end the node.

    rclpy has no public way to stand between a node's clock and its topic.
    """
    source = node._time_source
    follow = source.clock_callback

    def tick(message: Tick) -> None:
        if message.clock.sec < 0:
            told = f"refused /clock: expected 0 s or later, got {message.clock.sec} s"
            node.get_logger().warning(told, throttle_duration_sec=1.0)
            return
        follow(message)

    # for a subscription that is yet to come
    source.clock_callback = tick  # type: ignore[method-assign, assignment]
    if source._clock_sub is not None:
        source._clock_sub.callback = tick


def stamp_of(nanoseconds: int) -> Time:
    """Stamp of a time [ns]."""
    sec, nanosec = divmod(nanoseconds, SECOND)
    return Time(sec=sec, nanosec=nanosec)


def stamp_of_seconds(seconds: float) -> Time:
    """Stamp of a time [s], to the nanosecond."""
    return stamp_of(round(seconds * SECOND))


def nanoseconds(stamp: Time) -> int:
    """Time of a stamp [ns]."""
    return int(stamp.sec * SECOND + stamp.nanosec)


def seconds(stamp: Any) -> float:
    """Time of a stamp, or length of a duration [s]."""
    return float(stamp.sec + 1e-9 * stamp.nanosec)


def heard(publisher: Publisher) -> bool:
    """Whether anybody has subscribed; asking takes 0.6 us, publishing to nobody ten times that."""
    return bool(publisher.get_subscription_count())


class TakenByHand(CallbackGroup):
    """Entities whose messages their owner takes; executors leave them alone.

    At some hundred messages a second a callback each through an executor costs more than the work.
    """

    def can_execute(self, entity: Any) -> bool:
        """Never for an executor."""
        return False

    def beginning_execution(self, entity: Any) -> bool:
        """Never for an executor."""
        return False

    def ending_execution(self, entity: Any) -> None:
        """Never called, as nothing begins."""


def subscribe_by_hand(node: Node, kind: Any, topic: str, qos: QoSProfile) -> Subscription:
    """Subscription of `node` whose messages are fetched by `take`."""
    return node.create_subscription(kind, topic, unused, qos, callback_group=TakenByHand())


def take(subscription: Subscription) -> Any:
    """The next message that waits at a subscription; None when there is none."""
    taken = subscription.handle.take_message(subscription.msg_type, False)
    return None if taken is None else taken[0]


def slow_clock(node: Node, period: float) -> None:
    """Set the clock of a node that follows /clock every `period` [s] of wall time.

    A tick through an executor of rclpy takes 0.4 ms, a hundred times a simulated second.
    """

    def look() -> None:
        """Take the newest tick of /clock by hand, in place of its callback."""
        for subscription in node.subscriptions:
            if subscription.topic_name == "/clock" and subscription.callback is not unused:
                # with its events: beside them a wait set wakes for data that nobody takes
                events: Any = subscription.event_handlers
                for entity in [subscription, *events]:
                    entity.callback_group = by_hand
                tick = take(subscription)
                if tick is not None:
                    subscription.callback(tick)

    by_hand = TakenByHand()
    # on steady time: simulated time goes on only when it has looked
    node.create_timer(period, look, clock=Clock(clock_type=ClockType.STEADY_TIME))
    look()


class Inbox:
    """Messages of a topic that its owner waits for, in a wait set of its own.

    Args:
        node: whose topic it is.
        kind, topic, qos: as for a subscription.
    """

    def __init__(self, node: Node, kind: Any, topic: str, qos: QoSProfile) -> None:
        self._subscription = subscribe_by_hand(node, kind, topic, qos)
        self._wait_set = rclpy_implementation.WaitSet(1, 0, 0, 0, 0, 0, node.context.handle)

    def take(self, timeout: float = 0.0) -> Any:
        """The next message, which may come within `timeout` [s]; None when there is none."""
        message = take(self._subscription)
        if message is not None or timeout <= 0.0:
            return message
        self._wait_set.clear_entities()
        self._wait_set.add_subscription(self._subscription.handle)
        self._wait_set.wait(int(timeout * 1e9))
        return take(self._subscription)

    def publishers(self) -> int:
        """How many nodes publish on the topic."""
        return int(self._subscription.get_publisher_count())


def unused(_: Any) -> None:
    """Stand-in where rclpy asks for a callback."""
