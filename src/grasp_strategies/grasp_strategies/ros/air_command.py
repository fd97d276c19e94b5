"""Air commands on `pneumaticbox/command`, repeated for as long as the hand shall hold.

After `command_timeout` without a command the driver releases the air, for example when a sequencer
was killed. So a command is repeated while a strategy runs and, if the strategy has left the hand
filled, afterwards. With nothing to hold, the node has no publisher, so that other nodes do not
count it as a commander.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from builtin_interfaces.msg import Time
from rclpy.node import Node
from rclpy.publisher import Publisher
from rclpy.subscription import Subscription
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

from grasp_strategies.scene import AirTarget
from softhand_ros.topics import stamp_of_seconds

AIR_COMMAND_TOPIC = "pneumaticbox/command"
# [s] of scene time after which a command is repeated while a strategy runs
COMMAND_REPEAT_PERIOD = 0.5


class AirCommand:
    """Publisher of air commands.

    `begin` and `hold` must be called in the executor's thread, which may create and destroy
    publishers; the other methods in the strategy's thread.
    """

    def __init__(self, node: Node) -> None:
        self._node = node
        self._publisher: Publisher | None = None
        self._standing: JointTrajectory | None = None  # the command that stands
        self._sent_at = 0.0  # [s] of scene time
        self._others: Subscription | None = None  # commands of all, while what was grasped is held
        self._taken_over = False  # another node has commanded since

    def begin(self) -> None:
        """Create the publisher of air commands; stop listening to the commands of other nodes."""
        self._listen_no_longer()
        if self._publisher is None:
            self._publisher = self._node.create_publisher(JointTrajectory, AIR_COMMAND_TOPIC, 10)

    def missing(self) -> str:
        """What the air commands still lack, such as a subscriber; empty when nothing is missing."""
        if self._publisher is None or self._publisher.get_subscription_count():
            return ""
        return f"a subscriber of {self._publisher.topic_name}"

    def send(self, channels: Sequence[str], target: AirTarget, now: float, effect: float) -> None:
        """Publish a target of the channels at scene time `now` [s]. It takes effect at the time
        `effect` [s]; 0: at once. Each channel uses the field of its control mode.
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
        """Publish the latest command again if COMMAND_REPEAT_PERIOD has passed at scene time `now`
        [s].
        """
        if not 0 <= now - self._sent_at < COMMAND_REPEAT_PERIOD:
            self._publish(now)

    def forget(self) -> None:
        """Drop the latest command, since the air has been vented."""
        self._standing = None

    def hold(self, obeyed: bool) -> bool:
        """After a strategy: repeat the latest command if it holds air, else destroy the publisher;
        returns whether air is held.

        `obeyed` says whether the driver takes commands. When another node commands the air, this
        one stops repeating.
        """
        if self._publisher is None:
            return False
        if obeyed and self._fills and not self._taken_over:
            if self._others is None:
                self._others = self._node.create_subscription(
                    JointTrajectory, AIR_COMMAND_TOPIC, self._compare, 10
                )
            self._publish(self._sent_at)
            return True
        self._listen_no_longer()
        self._node.destroy_publisher(self._publisher)
        self._publisher = self._standing = None
        return False

    def _compare(self, message: JointTrajectory) -> None:
        """Note a command that is not the one that stands: it comes from another node."""
        standing = self._standing
        self._taken_over |= standing is not None and (
            (message.joint_names, message.points) != (standing.joint_names, standing.points)
        )

    def _listen_no_longer(self) -> None:
        if self._others is not None:
            self._node.destroy_subscription(self._others)
        self._others, self._taken_over = None, False

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
