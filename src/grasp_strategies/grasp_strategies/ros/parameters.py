"""Parameters of the node `grasp_sequencer`."""

from __future__ import annotations

from grasp_strategies.dexterity.feix import COUNT
from grasp_strategies.sequencer import ABORT_ACTIONS, CONTROL_STEP, VENT
from softhand_ros.parameters import Parameter
from softhand_ros.single import ALLOW_SECOND

STRATEGY_PREFIX = "strategy."
# what each service runs unless told otherwise: the first that is for the hand
SHIPPED = {
    "push": ("rbo_hand_1_push",),
    "surface_constrained": ("surface_constrained", "rbo_hand_1_surface"),
    "edge": ("rbo_hand_1_edge",),
    "slide_to_wall": ("rbo_hand_2_slide_to_wall",),
}
FEIX, FEIX_STRATEGY = "feix", "feix_strategy"  # a stored grasp, and the file that replays it
GRASP_SERVICES = (*SHIPPED, FEIX)
GRASP_TYPE, GRASP_PATTERNS = "grasp_type", "grasp_patterns"
LOWER_AND_RELEASE = "lower_and_release"


def _strategy_parameter(service: str) -> Parameter:
    shipped = " or ".join(SHIPPED.get(service, (FEIX_STRATEGY,)))
    if service in SHIPPED:
        shipped += ", by hand"
    text = f"what grasp/{service} runs, by name or path of a YAML file; empty: {shipped}"
    return Parameter(STRATEGY_PREFIX + service, "", text, read_only=False)


PARAMETERS = (
    Parameter("hand", "rbo_hand_2", "hand by name or path of its YAML"),
    Parameter(
        "abort_action",
        VENT,
        "what grasp/abort does with the air; vent opens every outlet, hold keeps it",
        choices=ABORT_ACTIONS,
        read_only=False,
    ),
    Parameter(
        LOWER_AND_RELEASE,
        True,
        "put the object down and let it go after the hold",
        read_only=False,
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
        "longest wall time to wait for simulator and driver",
        "s",
        (0.1, 120.0),
        read_only=False,
    ),
    Parameter(
        GRASP_TYPE,
        1,
        "of the Feix taxonomy, whose stored grasp grasp/feix replays",
        bounds=(1, COUNT),
        read_only=False,
    ),
    Parameter(
        GRASP_PATTERNS,
        "",
        "file of stored grasps, softhand-grasp-patterns/1; empty: the shipped one",
        read_only=False,
    ),
    ALLOW_SECOND,
    *map(_strategy_parameter, GRASP_SERVICES),
)
