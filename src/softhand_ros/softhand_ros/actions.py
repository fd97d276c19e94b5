"""Actions of control_msgs, offered on machines that have its types.

control_msgs comes with ROS and is not on PyPI: without it a node runs without these actions, and
logs that.
"""

from __future__ import annotations

from typing import Any

from rclpy.action import ActionServer, CancelResponse, GoalResponse
from rclpy.node import Node

try:
    from control_msgs import action as TYPES
except ImportError:
    TYPES = None

NO_ACTION_MESSAGE = "no control_msgs on this machine: the action {} is not offered"


def offer_action(node: Node, kind: str, name: str, behaviour: Any) -> Any:
    """Offer the action `name` of control_msgs' type `kind`; returns the type, or None if
    control_msgs is not installed.

    Args:
        node: the node that offers the action.
        kind: name of the type, such as `GripperCommand`.
        name: name of the action.
        behaviour: object with the methods `accepts(goal)`, which returns False to reject a goal;
            `cancel(handle)`, which must end the execution soon; and the coroutine
            `execute(handle)`, which returns the result.
    """
    if TYPES is None:
        node.get_logger().info(NO_ACTION_MESSAGE.format(name))
        return None

    def answer_goal(goal: Any) -> GoalResponse:
        return GoalResponse.ACCEPT if behaviour.accepts(goal) else GoalResponse.REJECT

    def answer_cancel(handle: Any) -> CancelResponse:
        behaviour.cancel(handle)
        return CancelResponse.ACCEPT

    action_type = getattr(TYPES, kind)
    ActionServer(
        node,
        action_type,
        name,
        behaviour.execute,
        goal_callback=answer_goal,
        cancel_callback=answer_cancel,
    )
    return action_type
