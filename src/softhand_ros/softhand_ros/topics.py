"""Topics: quality of service, time stamps, and subscriptions without callbacks."""

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

SECOND_NS = 10**9  # [ns]
RELIABLE = QoSProfile(depth=10, reliability=ReliabilityPolicy.RELIABLE)
# of publishers that tell their state at each step: what a reader misses while it waits for a core
# is sent again, up to twenty seconds at 200 Hz; less where the simulation is faster than real time
EACH_STEP = QoSProfile(depth=4000, reliability=ReliabilityPolicy.RELIABLE)
# For /clock, and only for messages of a fixed size: when parts of a large message are lost, a
# best-effort reader of Fast DDS keeps the received parts in memory, even after its publisher ended.
NEWEST = QoSProfile(depth=1, reliability=ReliabilityPolicy.BEST_EFFORT)
TICKS = QoSProfile(depth=50, reliability=ReliabilityPolicy.BEST_EFFORT)
# for subscribers that look for the message with a certain stamp
RELIABLE_DEEP = QoSProfile(depth=50, reliability=ReliabilityPolicy.RELIABLE)


def latched(depth: int) -> QoSProfile:
    """Quality of service of a topic whose last `depth` messages also reach late subscribers."""
    return QoSProfile(
        depth=depth,
        reliability=ReliabilityPolicy.RELIABLE,
        durability=DurabilityPolicy.TRANSIENT_LOCAL,
    )


def full_name(node: Node, name: str) -> str:
    """A name with the namespace of `node` in front, as in `left/wrist`."""
    return f"{node.get_namespace()}/{name}".strip("/")


def clock_conflict(node: Node) -> str:
    """A warning when more than one node publishes /clock, else empty."""
    count = node.count_publishers("/clock")
    if count < 2:
        return ""
    number = "two" if count == 2 else count
    return f"{number} nodes publish /clock: start all but one with publish_clock:=false"


def refuse_time_before_zero(node: Node) -> None:
    """Have `node` ignore ticks of /clock before 0 with a warning; rclpy would end the node.

    rclpy has no public way to filter the ticks that set a node's clock.
    """
    source = node._time_source
    follow = source.clock_callback

    def tick(message: Tick) -> None:
        if message.clock.sec < 0:
            refusal = f"refused /clock: expected 0 s or later, got {message.clock.sec} s"
            node.get_logger().warning(refusal, throttle_duration_sec=1.0)
            return
        follow(message)

    # for a subscription that is made later
    source.clock_callback = tick  # type: ignore[method-assign, assignment]
    if source._clock_sub is not None:
        source._clock_sub.callback = tick


def stamp_of(nanoseconds: int) -> Time:
    """Stamp of a time [ns]."""
    sec, nanosec = divmod(nanoseconds, SECOND_NS)
    return Time(sec=sec, nanosec=nanosec)


def stamp_of_seconds(seconds: float) -> Time:
    """Stamp of a time [s], rounded to the nanosecond."""
    return stamp_of(round(seconds * SECOND_NS))


def nanoseconds(stamp: Time) -> int:
    """Time of a stamp [ns]."""
    return int(stamp.sec * SECOND_NS + stamp.nanosec)


def seconds(stamp: Any) -> float:
    """Time of a stamp or a duration [s]."""
    return float(stamp.sec + 1e-9 * stamp.nanosec)


def now_of(node: Node) -> float:
    """Time of a node's clock [s], read without making the Time object that `Clock.now` returns."""
    return float(node.get_clock().handle.get_now().nanoseconds * 1e-9)


class Due:
    """Tells which samples are published: the first one in each period of a rate.

    Args:
        rate: rate [Hz] of publishing; 0: every sample.

    >>> due = Due(100.0)
    >>> [due(time) for time in (0.0, 0.002, 0.01, 0.012, 0.0)]
    [True, False, True, False, True]
    """

    def __init__(self, rate: float) -> None:
        self.rate = rate
        self._period: int | None = None

    def __call__(self, time: float) -> bool:
        """Whether the sample of this time [s] is published; call it once for each sample."""
        period = int(time * self.rate + 1e-6)
        due = not self.rate or period != self._period
        self._period = period
        return due


def has_subscribers(publisher: Publisher) -> bool:
    """Whether a topic has subscribers. Asking takes 0.6 us; publishing without subscribers takes
    ten times as long.
    """
    return bool(publisher.get_subscription_count())


class TakenByHand(CallbackGroup):
    """Callback group of entities that executors skip: their owner fetches the messages by `take`.

    At some hundred messages a second, callbacks through an executor cost more than the work itself.
    """

    def can_execute(self, entity: Any) -> bool:
        """False always."""
        return False

    def beginning_execution(self, entity: Any) -> bool:
        """False always."""
        return False

    def ending_execution(self, entity: Any) -> None:
        """Never called, as nothing begins."""


def subscribe_by_hand(
    node: Node, kind: Any, topic: str, qos: QoSProfile, raw: bool = False
) -> Subscription:
    """A subscription of `node` whose messages the caller fetches by `take`, as bytes if `raw`."""
    group = TakenByHand()
    return node.create_subscription(kind, topic, unused, qos, callback_group=group, raw=raw)


def take(subscription: Subscription) -> Any:
    """The next waiting message of a subscription; None when there is none."""
    taken = subscription.handle.take_message(subscription.msg_type, subscription.raw)
    return None if taken is None else taken[0]


def slow_clock(node: Node, period: float) -> None:
    """Update the clock of a node that follows /clock only every `period` [s] of wall time.

    A tick through an rclpy executor takes 0.4 ms, and there are a hundred in a simulated second.
    """

    def look() -> None:
        """Fetch the newest tick of /clock and pass it to the callback of its subscription."""
        for subscription in node.subscriptions:
            if subscription.topic_name == "/clock" and subscription.callback is not unused:
                # with its events: in their wait set, data of the subscription would wake it, too
                events: Any = subscription.event_handlers
                for entity in [subscription, *events]:
                    entity.callback_group = by_hand
                tick = take(subscription)
                if tick is not None:
                    subscription.callback(tick)

    by_hand = TakenByHand()
    # on steady time: simulated time advances only by `look`
    node.create_timer(period, look, clock=Clock(clock_type=ClockType.STEADY_TIME))
    look()


class Inbox:
    """A subscription whose owner fetches the messages and can wait for them, in its own wait set.

    Args:
        node: the node that subscribes.
        kind, topic, qos: message type, topic and quality of service, as for a subscription.
    """

    def __init__(self, node: Node, kind: Any, topic: str, qos: QoSProfile) -> None:
        self._subscription = subscribe_by_hand(node, kind, topic, qos)
        self._wait_set = rclpy_implementation.WaitSet(1, 0, 0, 0, 0, 0, node.context.handle)

    def take(self, timeout: float = 0.0) -> Any:
        """The next message; waits for it up to `timeout` [s]. None when none has come."""
        message = take(self._subscription)
        if message is not None or timeout <= 0.0:
            return message
        self._wait_set.clear_entities()
        self._wait_set.add_subscription(self._subscription.handle)
        self._wait_set.wait(int(timeout * 1e9))
        return take(self._subscription)

    def publishers(self) -> int:
        """Number of publishers of the topic."""
        return int(self._subscription.get_publisher_count())


def unused(_: Any) -> None:
    """A callback that does nothing, where rclpy requires one."""
