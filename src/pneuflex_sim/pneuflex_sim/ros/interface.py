"""What the node `hand_sim` offers to others, and its executable."""

from __future__ import annotations

import sys

from pneuflex_sim.ros.parameters import PARAMETERS
from softhand_ros.parameters import Offer, usage
from softhand_ros.run_node import start_node

PURPOSE = "Simulates a soft hand, its valves and an object, and publishes what is sensed."
OFFERS = (
    Offer("pub", "/clock", "rosgraph_msgs/Clock", "simulated time, by one simulator"),
    Offer("sub", "/clock", "rosgraph_msgs/Clock", "with publish_clock false: its time"),
    Offer("sub", "/clock_followers", "std_msgs/Header", "simulated times of the followers"),
    Offer("pub", "/clock_followers", "std_msgs/Header", "with publish_clock false: own time"),
    Offer("pub", "pneumaticbox/sensors", "sensor_msgs/JointState", "absolute pressures [Pa]"),
    Offer("sub", "pneumaticbox/valves", "sensor_msgs/JointState", "+1 inflate, -1 deflate, 0"),
    Offer("pub", "hand/joint_states", "sensor_msgs/JointState", "three angles a joint [rad]"),
    Offer("pub", "hand/tip_angles", "sensor_msgs/JointState", "tip against base [rad]"),
    Offer("pub", "hand/fingertips", "geometry_msgs/PoseArray", "poses in the wrist's frame"),
    Offer("pub", "hand/contacts", "visualization_msgs/MarkerArray", "forces by pair of bodies"),
    Offer("pub", "hand/markers", "visualization_msgs/MarkerArray", "the scene for viewers"),
    Offer("pub", "robot_description", "std_msgs/String", "URDF, latched"),
    Offer("pub", "wrist/pose", "geometry_msgs/PoseStamped", "of the compliant wrist, in world"),
    Offer("pub", "wrist/wrench", "geometry_msgs/WrenchStamped", "of the hand on the wrist"),
    Offer("sub", "wrist/target_pose", "geometry_msgs/PoseStamped", "target pose of the wrist"),
    Offer(
        "sub",
        "scene/hold_object",
        "trajectory_msgs/MultiDOFJointTrajectory",
        "pose at which a spring holds the object out to the hand, or its release",
    ),
    Offer("sub", "sim/commanded_until", "std_msgs/Header", "time until which it is commanded"),
    Offer("pub", "scene/object_pose", "geometry_msgs/PoseStamped", "truth, in world"),
    Offer("pub", "/tf", "tf2_msgs/TFMessage", "world to wrist and object, where tf2_msgs is there"),
    Offer("srv", "sim/reset", "std_srvs/Trigger", "back to the start"),
    Offer("srv", "sim/step", "std_srvs/Trigger", "one sample further, while paused"),
    Offer("srv", "sim/pause", "std_srvs/SetBool", "stand still, or go on"),
    Offer("pub", "/diagnostics", "diagnostic_msgs/DiagnosticArray", "once a second"),
)
HELP = usage("hand_sim", PURPOSE, PARAMETERS, OFFERS)


def main(args: list[str] | None = None) -> int:
    """Print the help of the node, or run it."""
    return start_node(HELP, "pneuflex_sim.ros.node", args)


if __name__ == "__main__":
    sys.exit(main())
