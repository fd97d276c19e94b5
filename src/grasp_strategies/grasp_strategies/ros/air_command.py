"""Commands of the air on `pneumaticbox/command`, repeated as long as the hand shall hold on.

The driver's `command_timeout` lets go what nobody commands any more, such as the hand of a
sequencer that was killed. So a command is repeated while a strategy runs and, where that has left
the hand filled, afterwards. With nothing to hold there is no publisher: the sequencer is no
commander then.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from builtin_interfaces.msg import Time
from rclpy.node import Node
from rclpy.publisher import Publisher
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

from grasp_strategies.scene import AirTarget
from softhand_ros.topics import stamp_of_seconds

TOPIC = "pneumaticbox/command"
HEARTBEAT = 0.5  # [s] of scene time after which a command is repeated while a strategy runs


class AirCommand:
    """The commander of the air. `begin` and `hold` are for the executor's thread, in which what a
    node publishes may come and go; the others for the strategy's.
    """

    def __init__(self, node: Node) -> None:
        self._node = node
        self._publisher: Publisher | None = None
        self._standing: JointTrajectory | None = None  # the command that stands
        self._sent_at = 0.0  # [s] of scene time

    def begin(self) -> None:
        """Become a commander."""
        if self._publisher is None:
            self._publisher = self._node.create_publisher(JointTrajectory, TOPIC, 10)

    def missing(self) -> str:
        """What is missing before the air can be commanded; empty when nothing is."""
        if self._publisher is None or self._publisher.get_subscription_count():
            return ""
        return f"a subscriber of {self._publisher.topic_name}"

    def send(self, channels: Sequence[str], target: AirTarget, now: float, effect: float) -> None:
        """Publish what the channels shall contain at `now` [s]; it takes effect at the time
        `effect` [s], 0: at once. Each channel reads the field of its mode.
        """
        named = ~(np.isnan(target.masses) & np.isnan(target.pressures))
        point = JointTrajectoryPoint(positions=np.nan_to_num(target.masses[named]).tolist())
        if not np.isnan(target.pressures).all():
            point.effort = np.nan_to_num(target.pressures[named]).tolist()
        names = [name for name, given in zip(channels, named, strict=True) if given]
        self._standing = JointTrajectory(joint_names=names, points=[point])
        self._standing.header.stamp = stamp_of_seconds(effect)
        self._publish(now)

    def repeat(self, now: float) -> None:
        """Publish what stands once more when it is time for that, at `now` [s] of scene time."""
        if not 0 <= now - self._sent_at < HEARTBEAT:
            self._publish(now)

    def forget(self) -> None:
        """Let no command stand: the air is out."""
        self._standing = None

    def hold(self, obeyed: bool) -> bool:
        """After a strategy: repeat what stands if it holds air, else be no commander any more.

        `obeyed` says whether the driver takes commands. Another commander takes the hand over.
        """
        if self._publisher is None:
            return False
        if obeyed and self._fills and self._node.count_publishers(TOPIC) == 1:
            self._publish(self._sent_at)
            return True
        self._node.destroy_publisher(self._publisher)
        self._publisher = self._standing = None
        return False

    @property
    def _fills(self) -> bool:
        standing = self._standing
        return standing is not None and any(
            (*standing.points[0].positions, *standing.points[0].effort)
        )

    def _publish(self, now: float) -> None:
        self._sent_at, standing = now, self._standing
        if self._publisher is not None and standing is not None:
            self._publisher.publish(standing)
            standing.header.stamp = Time()  # said again, it stands already
