"""Declares the parameters of the node `pneumaticbox` and chooses the clock that it follows."""

from __future__ import annotations

import rclpy
from rcl_interfaces.msg import FloatingPointRange, IntegerRange, ParameterDescriptor
from rclpy.node import Node

from pneumaticbox_driver.parameters import PARAMETERS, Parameter

SIM_TIME = "use_sim_time"


def sim_time_ignored(backend: str) -> str:
    """Say that a backend without a simulator does not follow simulated time."""
    return f"{SIM_TIME} is ignored: backend {backend} follows the wall clock"


def _descriptor(parameter: Parameter) -> ParameterDescriptor:
    descriptor = ParameterDescriptor(
        description=parameter.description, read_only=parameter.read_only
    )
    if parameter.bounds is None:
        return descriptor
    low, high = parameter.bounds
    if isinstance(parameter.default, int):
        descriptor.integer_range = [IntegerRange(from_value=int(low), to_value=int(high), step=1)]
    else:
        descriptor.floating_point_range = [FloatingPointRange(from_value=low, to_value=high)]
    return descriptor


def declare_parameters(node: Node) -> None:
    """Declare every parameter of the driver on `node`."""
    for parameter in PARAMETERS:
        node.declare_parameter(parameter.name, parameter.default, _descriptor(parameter))


def choose_clock(node: Node, backend: str) -> str:
    """Set use_sim_time of `node` to what its backend needs.

    Backend topic follows simulated time unless the user has said otherwise; the others have no
    /clock and always follow the wall clock.

    Returns:
        A warning, "" for none.
    """
    if backend != "topic":
        return _follow_wall_time(node, backend)
    # rclpy has no public way to tell a value that was given from its default: overrides of the
    # constructor would win over those of the command line and of parameter files
    if SIM_TIME not in node._parameter_overrides:
        node.set_parameters([rclpy.Parameter(SIM_TIME, value=True)])
    return ""


def _follow_wall_time(node: Node, backend: str) -> str:
    if not node.get_parameter(SIM_TIME).value:
        return ""
    node.set_parameters([rclpy.Parameter(SIM_TIME, value=False)])
    warning = sim_time_ignored(backend)
    node.get_logger().warning(warning)
    return warning
