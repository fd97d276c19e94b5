"""Reads topics of a bag as arrays over simulated time."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from model_lab.measurements.bags.limits import AnyReader
from softhand_common.documents.quoted import shortened
from softhand_common.numerics.arrays import Array


@dataclass(frozen=True)
class JointSeries:
    """A topic of sensor_msgs/JointState: `time` (k,) [s], its fields (k, n), or (k, 0) if empty."""

    time: Array
    names: tuple[str, ...]
    position: Array
    velocity: Array
    effort: Array


@dataclass(frozen=True)
class PoseSeries:
    """A topic of geometry_msgs/PoseStamped: `time` (k,) [s], positions (k, 3) [m], quaternions
    (k, 4).
    """

    time: Array
    position: Array
    orientation: Array

    def at(self, time: Array) -> PoseSeries:
        """The latest pose at each of these times [s]; before the first pose, the first."""
        index = latest_index(self.time, time)
        return PoseSeries(np.asarray(time), self.position[index], self.orientation[index])


@dataclass(frozen=True)
class Command:
    """One trajectory_msgs/JointTrajectory: times of reception and start [s], and its points."""

    received: float
    start: float
    names: tuple[str, ...]
    time_from_start: Array
    position: Array


class Bag:
    """A rosbag2 folder; a context manager.

    Args:
        folder: the bag, with its `metadata.yaml`.

    Raises:
        ValueError: the bag cannot be read; methods raise it, too, for damaged messages. A truncated
            bag needs `softhand_bringup.bags.repair` first.
    """

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        with _naming_the_bag(folder):
            self._reader = AnyReader([folder])
            self._reader.open()
        self._clock = self._read_clock()

    def __enter__(self) -> Bag:
        return self

    def __exit__(self, *_: object) -> None:
        self._reader.close()

    def topics(self) -> dict[str, int]:
        """Number of messages by topic."""
        return {name: topic.msgcount for name, topic in self._reader.topics.items()}

    def messages(self, topic: str) -> Iterator[tuple[float, Any]]:
        """Pairs (simulated time of reception [s], message) of a topic; none if the topic was not
        recorded.
        """
        for stamp, message in self._raw(topic):
            yield self._simulated(stamp), message

    def joints(self, topic: str) -> JointSeries:
        """A topic of sensor_msgs/JointState.

        Raises:
            ValueError: the topic has no messages.
        """
        messages = self._all(topic)
        return JointSeries(
            time=np.array([stamp_seconds(m.header.stamp) for m in messages]),
            names=tuple(messages[0].name),
            position=np.array([m.position for m in messages]),
            velocity=np.array([m.velocity for m in messages]),
            effort=np.array([m.effort for m in messages]),
        )

    def poses(self, topic: str) -> PoseSeries:
        """A topic of geometry_msgs/PoseStamped.

        Raises:
            ValueError: the topic has no messages.
        """
        messages = self._all(topic)
        positions = [m.pose.position for m in messages]
        orientations = [m.pose.orientation for m in messages]
        return PoseSeries(
            time=np.array([stamp_seconds(m.header.stamp) for m in messages]),
            position=np.array([[p.x, p.y, p.z] for p in positions]),
            orientation=np.array([[q.x, q.y, q.z, q.w] for q in orientations]),
        )

    def texts(self, topic: str) -> list[tuple[float, str]]:
        """Pairs (simulated time of reception [s], text) of a topic of std_msgs/String."""
        return [(time, message.data) for time, message in self.messages(topic)]

    def commands(self, topic: str) -> list[Command]:
        """A topic of trajectory_msgs/JointTrajectory; a command with stamp 0 starts at its
        reception.
        """
        commands = []
        for received, message in self.messages(topic):
            stamp = stamp_seconds(message.header.stamp)
            points = message.points
            commands.append(
                Command(
                    received=received,
                    start=stamp if stamp > 0 else received,
                    names=tuple(message.joint_names),
                    time_from_start=np.array([stamp_seconds(p.time_from_start) for p in points]),
                    position=np.array([p.positions for p in points]),
                )
            )
        return commands

    def _all(self, topic: str) -> list[Any]:
        messages = [message for _, message in self.messages(topic)]
        if not messages:
            raise ValueError(f"{topic}: expected messages in the bag, got none")
        return messages

    def _raw(self, topic: str) -> Iterator[tuple[int, Any]]:
        """(stamp of reception [ns], message) of a topic."""
        connections = [c for c in self._reader.connections if c.topic == topic]
        if not connections:  # for the reader, an empty list means all
            return
        messages = self._reader.messages(connections=connections)
        while True:
            with _naming_the_bag(self._folder):
                found = next(messages, None)
                if found is None:
                    return
                connection, stamp, data = found
                message = self._reader.deserialize(data, connection.msgtype)
            yield stamp, message

    def _read_clock(self) -> tuple[NDArray[np.int64], Array]:
        """Stamps of reception [ns] of the ticks of /clock, and their simulated times [s]."""
        ticks = [(stamp, stamp_seconds(message.clock)) for stamp, message in self._raw("/clock")]
        stamps = np.array([stamp for stamp, _ in ticks], dtype=np.int64)
        return stamps, np.array([time for _, time in ticks])

    def _simulated(self, received: int) -> float:
        stamps, times = self._clock
        if len(stamps) == 0:  # recorded on hardware: no /clock, seconds since the start of the bag
            return (received - self._reader.start_time) * 1e-9
        return float(np.interp(received - stamps[0], stamps - stamps[0], times))


@contextmanager
def _naming_the_bag(folder: Path) -> Iterator[None]:
    """Turn any error of rosbags into a ValueError that names the bag."""
    try:
        yield
    except Exception as reason:
        got = shortened(f"{type(reason).__name__}: {reason}")
        raise ValueError(
            f"{folder}: expected a bag that can be read, got {got}; `softhand repair-bag` repairs "
            "a truncated one"
        ) from reason


def stamp_seconds(stamp: Any) -> float:
    """Seconds of a ROS time or duration.

    >>> from types import SimpleNamespace
    >>> stamp_seconds(SimpleNamespace(sec=2, nanosec=500_000_000))
    2.5
    """
    return stamp.sec + 1e-9 * stamp.nanosec


def latest_index(known: Array, asked: Array) -> NDArray[np.int64]:
    """For each time in `asked`, the index of the last of the rising times `known` that is not later
    than it; 0 if all are later.

    >>> latest_index(np.array([0.0, 1.0, 2.0]), np.array([-1.0, 1.0, 1.9])).tolist()
    [0, 1, 1]
    """
    return np.maximum(np.searchsorted(known, asked, side="right") - 1, 0)
