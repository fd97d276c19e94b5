"""Node parameters: one table for each node, for declaration, help text and documentation.

The help text also lists topics and services.
"""

from __future__ import annotations

import difflib
import json
import reprlib
import sys
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Any, NamedTuple

import rclpy
import yaml
from rcl_interfaces.msg import (
    FloatingPointRange,
    IntegerRange,
    ParameterDescriptor,
    SetParametersResult,
)
from rclpy.node import Node

SIM_TIME = "use_sim_time"
OF_ROS = ("qos_overrides.",)  # prefixes of parameters that ROS declares later


@dataclass(frozen=True)
class Parameter:
    """One parameter of a node.

    Args:
        name, default: name and default value, as in ROS.
        description: its meaning; the part behind a semicolon explains special values.
        unit: unit of the value, or of each value of a list.
        bounds: smallest and largest value of a number; None for no limits.
        choices: allowed values of a text, or of each text of a list; empty for any.
        read_only: whether it cannot be changed while the node runs.

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
        """The allowed values in words; empty when any value of its type is allowed."""
        if self.bounds:
            low, high = self.bounds
            return f"{low:.10g} to {high:.10g}"
        return ", ".join(choice or '""' for choice in self.choices)

    def refusal(self, value: Any) -> str:
        """Error message for a value that is not among `choices`, else empty. ROS itself checks
        bounds.

        >>> Parameter("action", "vent", "of abort", choices=("vent", "hold")).refusal("drop")
        "action: expected one of vent, hold, got 'drop'"
        """
        given = [value] if isinstance(value, str) else value
        wrong = [entry for entry in given if entry not in self.choices] if self.choices else []
        if not wrong:
            return ""
        return f"{self.name}: expected one of {self.domain}, got {reprlib.repr(wrong[0])}"

    def descriptor(self) -> ParameterDescriptor:
        """The descriptor that `ros2 param describe` shows."""
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
    """A topic, a service or an action of a node: way (pub, sub, srv or action), name, ROS type and
    meaning. <channel> in a name stands for each channel of the hand.
    """

    way: str
    name: str
    kind: str
    meaning: str


def declare(node: Node, table: Table, neighbours: Table = ()) -> dict[str, Any]:
    """Declare the parameters of a table on `node`; returns their values by name.

    An integer is accepted for a parameter whose default is a float; true and false are accepted for
    one whose default is text. Later changes to a value that is none of the choices are refused.
    `neighbours` are the parameters of other nodes in this process: they may be given, too, and are
    left to those nodes.

    Raises:
        ValueError: a parameter was given that the node does not have, or a value that is none of
            the choices.
    """
    refuse_unknown(node, (*table, *neighbours), given_to_all(sys.argv))
    _take_near_types(node, table)
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


def refuse_unknown(node: Node, table: Table, shared: Collection[str]) -> None:
    """Refuse parameters that the user gave at the start and that are not in the table.

    ROS would ignore a misspelled parameter, and the hand would not move as intended. A parameter in
    `shared`, which a file gives to all nodes, is only logged as a warning.

    Raises:
        ValueError: names each unknown parameter and the most similar known one.
    """
    known = [row.name for row in table]
    refused = []
    for name in node._parameter_overrides:
        if name in known or node.has_parameter(name) or name.startswith(OF_ROS):
            continue
        near = difflib.get_close_matches(name, known, 1)
        text = f"no parameter {name}" + (f", did you mean {near[0]}?" if near else "")
        if name in shared:
            node.get_logger().warning(f"{text} (given to all nodes by a file: ignored)")
        else:
            refused.append(text)
    if refused:
        raise ValueError(f"{'; '.join(refused)} (--help lists the parameters)")


def given_to_all(words: Sequence[str]) -> set[str]:
    """Names of parameters that the parameter files of a command line give to all nodes (`/**`)."""
    paths = [path for option, path in pairwise(words) if option == "--params-file"]
    found: set[str] = set()
    for path in paths:
        found |= _shared_names(yaml.safe_load(Path(path).read_text()) or {}, "")
    return found


def _shared_names(sections: Mapping[str, Any], node: str) -> set[str]:
    found: set[str] = set()
    for key, content in sections.items():
        if key == "ros__parameters":
            found |= set(_dotted(content or {})) if node.endswith("*") else set()
        elif isinstance(content, Mapping):
            found |= _shared_names(content, key)
    return found


def _dotted(values: Mapping[str, Any]) -> Iterator[str]:
    for name, value in values.items():
        if isinstance(value, Mapping):
            yield from (f"{name}.{rest}" for rest in _dotted(value))
        else:
            yield name


def _take_near_types(node: Node, table: Table) -> None:
    """Read `-p step:=1` as 1.0: rclpy accepts no integer for a double; true as a text likewise."""
    for row in table:
        given = node._parameter_overrides.get(row.name)
        if given is None:
            continue
        if isinstance(row.default, str) and isinstance(given.value, bool):
            text = json.dumps(given.value)
            node._parameter_overrides[row.name] = rclpy.Parameter(row.name, value=text)
        several = isinstance(row.default, list)
        if not isinstance(row.default[0] if several else row.default, float):
            continue
        value: Any = list(given.value) if several else given.value
        if all(type(one) is int for one in (value if several else [value])):
            value = [float(one) for one in value] if several else float(value)
            node._parameter_overrides[row.name] = rclpy.Parameter(row.name, value=value)


def _refusals(table: Table, values: Iterable[tuple[str, Any]]) -> str:
    known = {row.name: row for row in table}
    found = (known[name].refusal(value) for name, value in values if name in known)
    return "; ".join(filter(None, found))


def follow_simulated_time(node: Node) -> None:
    """Have `node` follow /clock unless the user has set `use_sim_time`.

    rclpy has no public way to find out whether a value was given: overrides of the constructor
    would replace those of the command line and of parameter files.
    """
    if SIM_TIME not in node._parameter_overrides:
        node.set_parameters([rclpy.Parameter(SIM_TIME, value=True)])


def usage(command: str, purpose: str, table: Table, offers: Sequence[Offer]) -> str:
    """The text of `command --help`: every parameter, topic and service with its meaning.

    Args:
        command: name of the command.
        purpose: a sentence on what the node does.
        table: its parameters.
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
    """One line of help for each parameter, below a heading."""
    lines = ["Parameters, * for those that may change while it runs:", ""]
    width = max(len(row.name) for row in table)
    for row in table:
        mark = " " if row.read_only else "*"
        domain = f"{row.domain}; " if row.domain else ""
        default = f"({domain}default: {json.dumps(row.default)})"
        lines.append(f"{mark} {row.name:<{width}} {row.text} {default}")
    return lines


def offer_lines(offers: Sequence[Offer]) -> list[str]:
    """One line of help for each topic and service, below a heading."""
    lines = ["Topics it publishes (pub) and subscribes to (sub), and services (srv):", ""]
    names = max(len(row.name) for row in offers)
    types = max(len(row.kind) for row in offers)
    for row in offers:
        lines.append(f"  {row.way} {row.name:<{names}}  {row.kind:<{types}}  {row.meaning}")
    return lines


def markdown(table: Table) -> str:
    """The parameters as a Markdown table for the documentation; `*` marks those that may change
    while the node runs.
    """
    lines = ["| parameter | default | meaning |", "|---|---|---|"]
    for row in table:
        mark = "" if row.read_only else "*"
        domain = f" ({row.domain})" if row.domain else ""
        default = json.dumps(row.default)
        lines.append(f"| `{row.name}`{mark} | `{default}` | {row.text}{domain} |")
    return "\n".join(lines)
