"""What the node `grasp_sequencer` offers to others, and its executable `sequencer`."""

from __future__ import annotations

import sys

from grasp_strategies.ros.parameters import GRASP_SERVICES, PARAMETERS, STRATEGY_PREFIX
from softhand_ros.parameters import Offer, usage
from softhand_ros.run_node import start_node

PURPOSE = "Offers grasp services, each of which runs a strategy."
OFFERS = (
    *(
        Offer("srv", f"grasp/{name}", "std_srvs/Trigger", f"grasps as {STRATEGY_PREFIX}{name} says")
        for name in GRASP_SERVICES
    ),
    Offer("srv", "grasp/abort", "std_srvs/Trigger", "ends what runs"),
    Offer(
        "action",
        "~/gripper_cmd",
        "control_msgs/GripperCommand",
        "as gripper_type says, where control_msgs is there",
    ),
    Offer("pub", "grasp/phase", "std_msgs/String", "on every change, latched"),
    Offer("pub", "grasp/result", "diagnostic_msgs/DiagnosticArray", "how it ended, latched"),
    Offer("pub", "wrist/target_pose", "geometry_msgs/PoseStamped", "target pose of the wrist"),
    Offer(
        "pub",
        "scene/hold_object",
        "trajectory_msgs/MultiDOFJointTrajectory",
        "pose at which the object is held out to the hand, or its release",
    ),
    Offer("pub", "sim/commanded_until", "std_msgs/Header", "time until which it has commanded"),
    Offer(
        "pub",
        "pneumaticbox/command",
        "trajectory_msgs/JointTrajectory",
        "air masses while it works",
    ),
    Offer("sub", "pneumaticbox/state", "sensor_msgs/JointState", "air masses and pressures"),
    Offer("sub", "wrist/pose", "geometry_msgs/PoseStamped", "of the wrist, in world"),
    Offer("sub", "wrist/wrench", "geometry_msgs/WrenchStamped", "of the hand on the wrist"),
    Offer("sub", "scene/object_pose", "geometry_msgs/PoseStamped", "of the object, in world"),
    Offer("sub", "hand/contacts", "visualization_msgs/MarkerArray", "what touches the object"),
    Offer("sub", "/clock", "rosgraph_msgs/Clock", "simulated time"),
    Offer("sub", "/diagnostics", "diagnostic_msgs/DiagnosticArray", "faults of the others"),
    Offer("pub", "/diagnostics", "diagnostic_msgs/DiagnosticArray", "once a second"),
)
HELP = usage("sequencer", PURPOSE, PARAMETERS, OFFERS)


def main(args: list[str] | None = None) -> int:
    """Print the help of the node, or run it."""
    return start_node(HELP, "grasp_strategies.ros.node", args)


if __name__ == "__main__":
    sys.exit(main())
