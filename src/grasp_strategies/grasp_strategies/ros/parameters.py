"""Parameters of the node `grasp_sequencer`."""

from __future__ import annotations

from grasp_strategies.sequencer import ABORT_ACTIONS, CONTROL_STEP, VENT_ACTION
from softhand_ros.parameters import Parameter
from softhand_ros.single import ALLOW_SECOND

STRATEGY_PREFIX = "strategy."
# what each service runs unless told otherwise: the first that is for the hand
SHIPPED_STRATEGIES = {
    "push": ("rbo_hand_1_push",),
    "surface_constrained": ("surface_constrained", "rbo_hand_1_surface"),
    "edge": ("rbo_hand_1_edge",),
    "slide_to_wall": ("rbo_hand_2_slide_to_wall",),
    "feix": ("feix/01",),  # a stored grasp of the Feix taxonomy
}
GRASP_SERVICES = tuple(SHIPPED_STRATEGIES)
GRIPPER_TYPES = ("GripperCommand", "ParallelGripperCommand")  # of control_msgs
LOWER_AND_RELEASE = "lower_and_release"
PREPARE_TIME_OUT = "prepare_time_out"


def _strategy_parameter(service: str) -> Parameter:
    shipped = " or ".join(SHIPPED_STRATEGIES[service])
    text = f"what grasp/{service} runs: name or path of a YAML file; empty: shipped ({shipped})"
    return Parameter(STRATEGY_PREFIX + service, "", text, read_only=False)


PARAMETERS = (
    Parameter("hand", "rbo_hand_2", "hand by name or path of its YAML"),
    Parameter(
        "abort_action",
        VENT_ACTION,
        "what grasp/abort, or a cancel, does with the air; vent opens every outlet, hold keeps it",
        choices=ABORT_ACTIONS,
        read_only=False,
    ),
    Parameter(
        LOWER_AND_RELEASE, True, "put the object down and let it go after the hold", read_only=False
    ),
    Parameter(
        "control_step",
        CONTROL_STEP,
        "scene time between two commands to the wrist",
        "s",
        (0.002, 0.1),
        read_only=False,
    ),
    Parameter(
        "connect_time_out",
        10.0,
        "longest wall time to wait for simulator and driver, not counting their compilation",
        "s",
        (0.1, 120.0),
        read_only=False,
    ),
    # a first start compiles for about a minute, on a busy machine for two
    Parameter(
        PREPARE_TIME_OUT,
        120.0,
        "longest wall time from a call to its first phase, including compilation",
        "s",
        (0.1, 600.0),
        read_only=False,
    ),
    Parameter(
        "gripper_type",
        GRIPPER_TYPES[0],
        "type of the action gripper_cmd, where control_msgs is installed",
        choices=GRIPPER_TYPES,
    ),
    Parameter(
        "gripper_strategy",
        "surface_constrained",
        "the grasp service whose strategy closes the hand for gripper_cmd",
        choices=GRASP_SERVICES,
        read_only=False,
    ),
    ALLOW_SECOND,
    *map(_strategy_parameter, GRASP_SERVICES),
)
