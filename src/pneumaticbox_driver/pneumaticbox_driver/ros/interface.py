"""Topics and services of the node `pneumaticbox`, and its executable `driver`."""

from __future__ import annotations

import sys

from pneumaticbox_driver.ros.parameters import PARAMETERS
from softhand_ros.parameters import Offer, usage
from softhand_ros.run_node import start_node

PURPOSE = "Controls the air of a soft hand's channels over ROS 2."
OFFERS = (
    Offer(
        "sub", "pneumaticbox/command", "trajectory_msgs/JointTrajectory", "targets by control_mode"
    ),
    Offer(
        "sub",
        "pneumaticbox/valve_schedule",
        "trajectory_msgs/JointTrajectory",
        "+1 inflate, -1 deflate, 0 closed, for channels in mode time",
    ),
    Offer(
        "pub",
        "pneumaticbox/state",
        "sensor_msgs/JointState",
        "air mass [kg], mass flow [kg/s], gauge pressure [Pa]",
    ),
    Offer("pub", "pneumaticbox/<channel>/pressure", "sensor_msgs/FluidPressure", "absolute [Pa]"),
    Offer("pub", "pneumaticbox/supply/pressure", "sensor_msgs/FluidPressure", "absolute [Pa]"),
    Offer(
        "sub",
        "pneumaticbox/sensors",
        "sensor_msgs/JointState",
        "absolute pressures [Pa] with backend topic",
    ),
    Offer("pub", "pneumaticbox/valves", "sensor_msgs/JointState", "+1 inflate, -1 deflate, 0"),
    Offer("srv", "pneumaticbox/enable", "std_srvs/SetBool", "switch the control on or off"),
    Offer("srv", "pneumaticbox/vent", "std_srvs/Trigger", "open every outlet until reset"),
    Offer("srv", "pneumaticbox/reset", "std_srvs/Trigger", "leave the vented state"),
    Offer("srv", "pneumaticbox/tare", "std_srvs/Trigger", "count air masses from here"),
    Offer("srv", "pneumaticbox/calibrate", "std_srvs/Trigger", "calibrate on fixed volumes"),
    Offer("srv", "pneumaticbox/calibrate_next", "std_srvs/Trigger", "with the next supply"),
    Offer(
        "srv", "pneumaticbox/change_state", "lifecycle_msgs/ChangeState", "as ros2 lifecycle does"
    ),
    Offer(
        "srv",
        "pneumaticbox/get_state",
        "lifecycle_msgs/GetState",
        "unconfigured, inactive or active",
    ),
    Offer(
        "srv",
        "pneumaticbox/get_available_states",
        "lifecycle_msgs/GetAvailableStates",
        "all that there are",
    ),
    Offer(
        "srv",
        "pneumaticbox/get_available_transitions",
        "lifecycle_msgs/GetAvailableTransitions",
        "from the present state",
    ),
    Offer(
        "srv",
        "pneumaticbox/get_transition_graph",
        "lifecycle_msgs/GetAvailableTransitions",
        "from every state",
    ),
    Offer(
        "pub",
        "pneumaticbox/transition_event",
        "lifecycle_msgs/TransitionEvent",
        "at each transition",
    ),
    Offer(
        "action",
        "pneumaticbox/follow_joint_trajectory",
        "control_msgs/FollowJointTrajectory",
        "masses or pressures over time, where control_msgs is there",
    ),
    Offer("sub", "/clock", "rosgraph_msgs/Clock", "simulated time with backend topic"),
    Offer("pub", "/diagnostics", "diagnostic_msgs/DiagnosticArray", "once a second"),
)
HELP = usage("driver", PURPOSE, PARAMETERS, OFFERS)


def main(args: list[str] | None = None) -> int:
    """Print the help of the node, or run it."""
    return start_node(HELP, "pneumaticbox_driver.ros.node", args)


if __name__ == "__main__":
    sys.exit(main())
