"""Parameters of the sequencer node, each declared once: default, text, unit, range or choices."""

from __future__ import annotations

from dataclasses import dataclass

from grasp_strategies.sequencer import ABORT_ACTIONS, CONTROL_STEP, VENT

STRATEGY_PREFIX = "strategy."
GRASP_SERVICES = ("push", "surface_constrained", "edge", "slide_to_wall")
LOWER_AND_RELEASE = "lower_and_release"


@dataclass(frozen=True)
class NodeParameter:
    """One parameter: `least` to `most` for a number with its unit, `choices` for a text."""

    name: str
    default: str | float | bool
    description: str
    unit: str = ""
    least: float = 0.0
    most: float = 0.0
    choices: tuple[str, ...] = ()
    read_only: bool = False

    @property
    def text(self) -> str:
        """Description with the unit."""
        return f"{self.description} [{self.unit}]" if self.unit else self.description

    def refusal(self, value: object) -> str:
        """Why a value cannot be taken; empty when it can. Ranges of numbers ROS checks itself."""
        if self.choices and value not in self.choices:
            return f"{self.name}: expected one of {', '.join(self.choices)}, got {value!r}"
        return ""


def refusal_of(name: str, value: object) -> str:
    """Why a parameter cannot take a value; empty when it can or is none of ours.

    >>> refusal_of("abort_action", "drop")
    "abort_action: expected one of vent, hold, got 'drop'"
    """
    return "".join(known.refusal(value) for known in PARAMETERS if known.name == name)


def _strategy_parameter(service: str) -> NodeParameter:
    default = service if service == "surface_constrained" else ""
    text = f"What grasp/{service} runs: name of a strategy or path of a .yaml file; empty: none yet"
    return NodeParameter(STRATEGY_PREFIX + service, default, text)


PARAMETERS = (
    NodeParameter("hand", "rbo_hand_2", "Name or path of the hand description", read_only=True),
    NodeParameter(
        "abort_action",
        VENT,
        "What grasp/abort does with the air: vent opens every outlet, hold keeps it",
        choices=ABORT_ACTIONS,
    ),
    NodeParameter(LOWER_AND_RELEASE, True, "Put the object down and let it go after the hold"),
    NodeParameter(
        "control_step", CONTROL_STEP, "Between two commands to the wrist", "s, scene", 0.002, 0.1
    ),
    NodeParameter(
        "connect_time_out", 10.0, "Longest wait for simulator and driver", "s, wall", 0.1, 120.0
    ),
    *map(_strategy_parameter, GRASP_SERVICES),
)
