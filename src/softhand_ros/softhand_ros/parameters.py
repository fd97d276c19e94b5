"""Node parameters: one table a node, for the declaration, the help and the documentation.

The help tells of topics and services, too.
"""

from __future__ import annotations

import json
import reprlib
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import rclpy
from rcl_interfaces.msg import (
    FloatingPointRange,
    IntegerRange,
    ParameterDescriptor,
    SetParametersResult,
)
from rclpy.node import Node

SIM_TIME = "use_sim_time"


@dataclass(frozen=True)
class Parameter:
    """One parameter of a node.

    Args:
        name, default: as ROS has them.
        description: what it is; what stands behind a semicolon tells of special values.
        unit: of the value, or of each in a list.
        bounds: the least and the greatest value of a number, None for no range.
        choices: the values that a text, or each in a list, can have; empty for any.
        read_only: whether it cannot change while the node runs.

    >>> Parameter("hold", 1.0, "time in the air; 0: none", "s", (0.0, 9.0)).text
    'time in the air [s]; 0: none'
    """

    name: str
    default: Any
    description: str
    unit: str = ""
    bounds: tuple[float, float] | None = None
    choices: tuple[str, ...] = ()
    read_only: bool = True

    @property
    def text(self) -> str:
        """Description with the unit."""
        what, semicolon, special = self.description.partition(";")
        return f"{what} [{self.unit}]{semicolon}{special}" if self.unit else self.description

    @property
    def domain(self) -> str:
        """Which values it can have, in words; empty when any of its type will do."""
        if self.bounds:
            low, high = self.bounds
            return f"{low:.10g} to {high:.10g}"
        return ", ".join(choice or '""' for choice in self.choices)

    def refusal(self, value: Any) -> str:
        """Why a value is none of the choices; empty when it is. Ranges ROS checks itself.

        >>> Parameter("action", "vent", "of abort", choices=("vent", "hold")).refusal("drop")
        "action: expected one of vent, hold, got 'drop'"
        """
        given = [value] if isinstance(value, str) else value
        wrong = [entry for entry in given if entry not in self.choices] if self.choices else []
        if not wrong:
            return ""
        return f"{self.name}: expected one of {self.domain}, got {reprlib.repr(wrong[0])}"

    def descriptor(self) -> ParameterDescriptor:
        """What `ros2 param describe` tells."""
        made = ParameterDescriptor(
            description=self.text,
            read_only=self.read_only,
            additional_constraints=", ".join(self.choices),
        )
        if not self.bounds:
            return made
        low, high = self.bounds
        if isinstance(self.default, int):
            made.integer_range = [IntegerRange(from_value=int(low), to_value=int(high), step=1)]
        else:
            made.floating_point_range = [FloatingPointRange(from_value=low, to_value=high)]
        return made


Table = Sequence[Parameter]


class Offer(NamedTuple):
    """A topic or a service of a node: way (pub, sub or srv), name, kind of message as ROS writes
    it, and what it means. <channel> in a name stands for each of the hand's.
    """

    way: str
    name: str
    kind: str
    meaning: str


def declare(node: Node, table: Table) -> dict[str, Any]:
    """Declare the parameters of a table on `node`; their values by name.

    Raises:
        ValueError: a value that is none of the choices; later changes to such are refused.
    """
    values = {
        row.name: node.declare_parameter(row.name, row.default, row.descriptor()).value
        for row in table
    }
    refusals = _refusals(table, values.items())
    if refusals:
        raise ValueError(refusals)

    def check(changes: list[rclpy.Parameter]) -> SetParametersResult:
        reason = _refusals(table, ((change.name, change.value) for change in changes))
        return SetParametersResult(successful=not reason, reason=reason)

    node.add_on_set_parameters_callback(check)
    return values


def _refusals(table: Table, values: Iterable[tuple[str, Any]]) -> str:
    known = {row.name: row for row in table}
    found = (known[name].refusal(value) for name, value in values if name in known)
    return "; ".join(filter(None, found))


def follow_simulated_time(node: Node) -> None:
    """Have `node` follow /clock, unless the user has said otherwise.

    rclpy has no public way to tell a value that was given from its default: overrides of the
    constructor would win over those of the command line and of parameter files.
    """
    if SIM_TIME not in node._parameter_overrides:
        node.set_parameters([rclpy.Parameter(SIM_TIME, value=True)])


def usage(command: str, purpose: str, table: Table, offers: Sequence[Offer]) -> str:
    """What `command --help` prints: every parameter, topic and service with its meaning.

    Args:
        command: its name.
        purpose: what the node does, a sentence.
        table: of its parameters.
        offers: its topics and services.
    """
    lines = [
        f"usage: {command} [--ros-args -p NAME:=VALUE ... --params-file FILE -r __ns:=/NAMESPACE]",
        "",
        purpose,
        "",
        *parameter_lines(table),
        "",
        *offer_lines(offers),
    ]
    return "\n".join(lines)


def parameter_lines(table: Table) -> list[str]:
    """Parameters for the help, a line each."""
    lines = ["Parameters, * for those that may change while it runs:", ""]
    width = max(len(row.name) for row in table)
    for row in table:
        mark = " " if row.read_only else "*"
        domain = f"{row.domain}; " if row.domain else ""
        default = f"({domain}default: {json.dumps(row.default)})"
        lines.append(f"{mark} {row.name:<{width}} {row.text} {default}")
    return lines


def offer_lines(offers: Sequence[Offer]) -> list[str]:
    """Topics and services for the help, a line each."""
    lines = ["Topics it publishes (pub) and hears (sub), and services (srv):", ""]
    names = max(len(row.name) for row in offers)
    types = max(len(row.kind) for row in offers)
    for row in offers:
        lines.append(f"  {row.way} {row.name:<{names}}  {row.kind:<{types}}  {row.meaning}")
    return lines


def markdown(table: Table) -> str:
    """The table for the documentation."""
    lines = [
        "| parameter | default | unit | values | changes | meaning |",
        "|---|---|---|---|---|---|",
    ]
    for row in table:
        changes = "" if row.read_only else "yes"
        cells = (f"`{row.name}`", f"`{json.dumps(row.default)}`", row.unit, row.domain, changes)
        lines.append(f"| {' | '.join(cells)} | {row.description} |")
    return "\n".join(lines)
