"""QoS of a publisher in the form that a bag keeps, and the QoS to subscribe with.

Works on anything that has the fields of `rclpy.qos.QoSProfile`, so that it needs no ROS.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from rosbags.interfaces import (
    Qos,
    QosDurability,
    QosHistory,
    QosLiveliness,
    QosReliability,
    QosTime,
)


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
