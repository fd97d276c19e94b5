"""The node's parameters: default, description with unit, range, and whether they may change.

Declares the parameters of the node `pneumaticbox` and chooses the clock that it follows.
"""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import rclpy
from rcl_interfaces.msg import FloatingPointRange, IntegerRange, ParameterDescriptor
from rclpy.node import Node

from pneumaticbox_driver.settings import BoxSettings, per_channel
from softhand_model.hand.hand import load_hand

BACKENDS = ("topic", "embedded", "hardware")


@dataclass(frozen=True)
class Parameter:
    """One parameter; `bounds` are the smallest and largest value where there are any."""

    name: str
    default: Any
    description: str
    bounds: tuple[float, float] | None = None
    read_only: bool = True


PARAMETERS = (
    Parameter("hand", "rbo_hand_2", "hand on the box, by name or by the path of its YAML file"),
    Parameter("channels", [""], "names in the order of the outlets; one empty name: the hand's"),
    Parameter("rest_volumes", [0.0], "enclosed at rest with tubes, a channel [m3]; 0: the hand's"),
    Parameter("volume_model", "", "hand, fixed (bottles) or empty: hand if rest_volumes are its"),
    Parameter("pressure_limits", [0.0], "gauge, a channel [Pa]; 0: the hand's weakest actuator"),
    Parameter("control_mode", ["mass"], "one a channel, or one for all", read_only=False),
    Parameter("backend", "topic", "plant: topic (simulator), embedded (bottles) or hardware"),
    Parameter("calibration_file", "", "of `calibrate`; empty: that of the pretended box"),
    Parameter("outlets", [0], "whose coefficients a channel uses, from 1; one 0: in order"),
    Parameter("box", "", "name of this box and of its calibration; empty: any", read_only=False),
    Parameter(
        "calibration_volume",
        0.0,
        "fixed volume on every channel for calibrate [m3]; 0: none is there",
        (0.0, 0.1),
        read_only=False,
    ),
    Parameter(
        "calibration_points", 100, "pulses a channel for calibrate", (12, 10000), read_only=False
    ),
    Parameter(
        "calibration_supplies", 2, "supply pressures for calibrate", (1, 20), read_only=False
    ),
    Parameter(
        "calibration_leak_test",
        30.0,
        "time for which calibrate watches for leaks [s]; 0: it does not",
        (0.0, 3600.0),
        read_only=False,
    ),
    Parameter("calibration_output", "", "new file for calibrate to write", read_only=False),
    Parameter("drift_correction", False, "correct masses by still pressures", read_only=False),
    Parameter("leak_model", False, "take leaked air off by the calibration", read_only=False),
    Parameter("command_timeout", 0.0, "silence of commands that vents [s]; 0: hold", (0.0, 3600.0)),
    Parameter("shortest_pulse", 0.045, "least time that a valve stays open [s]", (0.001, 1.0)),
    Parameter("shortest_pause", 0.06, "least time that a valve stays closed [s]", (0.0, 1.0)),
    Parameter("zero_band", 5000.0, "largest offset of a channel's sensor [Pa]", (0.0, 50000.0)),
    Parameter("start_enabled", True, "take commands without a call of pneumaticbox/enable"),
    Parameter("channel_deviation", 2000.0, "of channel pressures, one sigma [Pa]", (0.0, 1e5)),
    Parameter("supply_deviation", 10000.0, "of the supply pressure, one sigma [Pa]", (0.0, 1e5)),
    Parameter("embedded_rate", 500.0, "control steps without a simulator [Hz]", (10.0, 1000.0)),
    Parameter("real_time_priority", 0, "SCHED_FIFO priority of the node; 0: ordinary", (0, 99)),
    Parameter("embedded_seed", 0, "of noise and jitter with backend embedded", (0, 2**31 - 1)),
    Parameter("embedded_plant", "", "YAML file of the pretended box; empty: the shipped one"),
    Parameter(
        "embedded_supply",
        0.0,
        "gauge, of backend embedded [Pa]; 0: that of its YAML file",
        (0.0, 1e6),
        read_only=False,
    ),
    Parameter("hardware_file", "", "YAML file of the box's wiring, for backend hardware"),
)


def usage() -> str:
    """What `driver --help` prints: every parameter with its description and default."""
    lines = [
        "usage: driver [--ros-args -p NAME:=VALUE ... --params-file FILE]",
        "",
        "Controls the air of a soft hand's channels over ROS 2; topics and services stand in",
        "docs/topics-and-services.md. Parameters, * for those that may change while it runs:",
        "",
    ]
    for parameter in PARAMETERS:
        mark = " " if parameter.read_only else "*"
        default = json.dumps(parameter.default)
        lines.append(f"{mark} {parameter.name:<22} {parameter.description} (default: {default})")
    return "\n".join(lines)


def check_backend(backend: str) -> str:
    """Return `backend` if it can be used.

    Raises:
        ValueError: there is none of that name.
    """
    if backend not in BACKENDS:
        raise ValueError(f"backend must be one of {list(BACKENDS)}, got {backend!r}")
    return backend


def box_settings(value: Callable[[str], Any]) -> BoxSettings:
    """Make the box's settings from parameters, with the hand's data where they say so.

    Args:
        value: returns a parameter's value by its name.

    Raises:
        ValueError: a hand that does not exist, or a value that cannot be used.
    """
    channels, volumes = tuple(value("channels")), tuple(value("rest_volumes"))
    limits, model = tuple(value("pressure_limits")), value("volume_model")
    if not model:
        # backend embedded has bottles unless it is told otherwise
        of_hand = volumes == (0.0,) and value("backend") != "embedded"
        model = "hand" if of_hand else "fixed"
    if channels == ("",) or volumes == (0.0,) or limits == (0.0,):
        hand = load_hand(value("hand"))
        channels = hand.channels if channels == ("",) else channels
        volumes = tuple(hand.rest_volumes().tolist()) if volumes == (0.0,) else volumes
        limits = tuple(hand.max_pressures().tolist()) if limits == (0.0,) else limits
    same = ("command_timeout", "shortest_pulse", "shortest_pause", "zero_band", "start_enabled")
    return BoxSettings(
        channels=channels,
        rest_volumes=volumes,
        pressure_limits=limits,
        control_modes=per_channel("control_mode", value("control_mode"), len(channels)),
        volume_model=model,
        hand=value("hand"),
        **{name: value(name) for name in same},
    )


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
