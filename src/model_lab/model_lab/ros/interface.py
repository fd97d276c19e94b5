"""What the node `monitor` offers to others, its parameters, and its executable."""

from __future__ import annotations

import sys

from softhand_ros.parameters import Offer, Parameter, usage
from softhand_ros.run_node import start_node

PURPOSE = "Compares tip angles, and fingertips, of a hand with those that a model predicts, live."
PARAMETERS = (
    Parameter("hand", "rbo_hand_2", "hand by name or path of its YAML"),
    Parameter("model_file", "", "softhand-model/1 file; empty: actuators with their weight"),
    Parameter("allow_effect_files", False, "run the Python files that the model file names"),
    Parameter("temperature", 293.15, "of the rubber", "K", (200.0, 500.0)),
    Parameter(
        "window", 5.0, "measured time over which the residual is averaged", "s", (0.1, 600.0)
    ),
    Parameter("warn_above", 0.05, "rms residual that is worth a warning", "rad", (0.0, 10.0)),
    Parameter(
        "stale_after", 2.0, "wall time without a comparison that is stale", "s", (0.1, 600.0)
    ),
    Parameter(
        "settle_time",
        0.1,
        "for which the pressure must have stood for a sample to count; 0: all count",
        "s",
        (0.0, 4.0),
    ),
    Parameter(
        "settle_band", 1000.0, "within which a pressure counts as standing", "Pa", (0.0, 1e5)
    ),
    Parameter("shadow", False, "predict the fingertips of a hand at rest, too"),
    Parameter(
        "warn_distance",
        0.005,
        "rms distance of the fingertips from the shadow's that is worth a warning",
        "m",
        (0.0, 1.0),
    ),
    Parameter(
        "contact_force",
        0.2,
        "force at the wrist that no free hand bears: what is off is contact",
        "N",
        (0.0, 100.0),
    ),
)
OFFERS = (
    Offer("sub", "pneumaticbox/state", "sensor_msgs/JointState", "gauge pressures [Pa]"),
    Offer("sub", "hand/tip_angles", "sensor_msgs/JointState", "measured, of the tips [rad]"),
    Offer("sub", "hand/fingertips", "geometry_msgs/PoseArray", "measured, with shadow"),
    Offer("sub", "wrist/pose", "geometry_msgs/PoseStamped", "how the hand is held, with shadow"),
    Offer("sub", "wrist/wrench", "geometry_msgs/WrenchStamped", "tells contact, with shadow"),
    Offer("sub", "/clock", "rosgraph_msgs/Clock", "simulated time with use_sim_time"),
    Offer("pub", "model/prediction", "sensor_msgs/JointState", "predicted angles [rad]"),
    Offer("pub", "model/residual", "sensor_msgs/JointState", "measured less predicted [rad]"),
    Offer("pub", "model/fingertips", "geometry_msgs/PoseArray", "predicted, with shadow"),
    Offer("pub", "/diagnostics", "diagnostic_msgs/DiagnosticArray", "once a second"),
)
HELP = usage("monitor", PURPOSE, PARAMETERS, OFFERS)


def main(args: list[str] | None = None) -> int:
    """Print how to use the node, or run it."""
    return start_node(HELP, "model_lab.ros.monitor", args)


if __name__ == "__main__":
    sys.exit(main())
