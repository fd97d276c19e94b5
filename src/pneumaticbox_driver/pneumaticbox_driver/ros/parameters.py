"""Parameters of the node `pneumaticbox`, the box's settings from them, and the node's clock."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import rclpy
from rclpy.node import Node

from pneumaticbox_driver.modes import MODES
from pneumaticbox_driver.settings import NOT_NEGATIVE, VOLUME_MODELS, BoxSettings, per_channel
from softhand_model.hand.hand import load_hand
from softhand_ros.parameters import SIM_TIME, Parameter, follow_simulated_time
from softhand_ros.single import ALLOW_SECOND

CANCEL_ACTIONS = ("hold", "vent")
BACKENDS = ("topic", "embedded", "hardware")

PARAMETERS = (
    Parameter("hand", "rbo_hand_2", "hand on the box, by name or by the path of its YAML file"),
    Parameter("channels", [""], "names in the order of the outlets; one empty name: the hand's"),
    Parameter(
        "rest_volumes",
        [0.0],
        "rest volume including tubing, per channel; one 0 takes it from the hand file",
        "m3",
    ),
    Parameter(
        "volume_model",
        "",
        "of volumes over pressure; fixed: bottles, empty: hand if rest_volumes are the hand's",
        choices=("", *VOLUME_MODELS),
    ),
    Parameter(
        "pressure_limits", [0.0], "gauge, per channel; one 0: of the hand's weakest actuator", "Pa"
    ),
    Parameter(
        "control_mode",
        ["mass"],
        "controlled quantity; one per channel, or one for all",
        choices=tuple(MODES),
        read_only=False,
    ),
    Parameter(
        "backend",
        "topic",
        "plant; topic: the simulator, embedded: simulated bottles, hardware: a real box",
        choices=BACKENDS,
    ),
    Parameter("calibration_file", "", "of `calibrate`; empty: that of the simulated box"),
    Parameter("outlets", [0], "outlet of each channel, from 1; one 0: in order"),
    Parameter("box", "", "name of this box and of its calibration; empty: any", read_only=False),
    Parameter(
        "calibration_volume",
        0.0,
        "fixed volume on every channel for calibrate; 0: none",
        "m3",
        (0.0, 0.1),
        read_only=False,
    ),
    Parameter(
        "calibration_points",
        100,
        "pulses per channel for calibrate",
        bounds=(12, 10000),
        read_only=False,
    ),
    Parameter(
        "calibration_supplies", 2, "supply pressures for calibrate", bounds=(1, 20), read_only=False
    ),
    Parameter(
        "calibration_leak_test",
        30.0,
        "duration of the leak test of calibrate; 0: none",
        "s",
        (0.0, 3600.0),
        read_only=False,
    ),
    Parameter("calibration_output", "", "new file for calibrate to write", read_only=False),
    Parameter("drift_correction", False, "correct masses by still pressures", read_only=False),
    Parameter("leak_model", False, "subtract leaks of the calibration", read_only=False),
    Parameter(
        "command_timeout",
        5.0,
        "time without a command after which it vents; 0: never, the last target is held",
        "s",
        (0.0, 3600.0),
    ),
    Parameter("command_lead", 60.0, "how far ahead a stamp may lie", "s", (0.0, 86400.0)),
    Parameter("command_span", 3600.0, "longest trajectory of a command", "s", (0.1, 86400.0)),
    Parameter("shortest_pulse", 0.045, "smallest time a valve is open", "s", (0.001, 1.0)),
    Parameter("shortest_pause", 0.06, "smallest time a valve is closed", "s", (0.0, 1.0)),
    Parameter("zero_band", 5000.0, "largest offset of a channel's sensor", "Pa", (0.0, 50000.0)),
    Parameter(
        "start_enabled",
        "",
        "take commands without a call of pneumaticbox/enable; empty: not with backend hardware",
        choices=("", "true", "false"),
    ),
    Parameter(
        "cancel_action",
        CANCEL_ACTIONS[0],
        "what the cancel of a trajectory does with the air; vent opens every outlet until reset",
        choices=CANCEL_ACTIONS,
        read_only=False,
    ),
    Parameter("channel_deviation", 2000.0, "of channel pressures, one sigma", "Pa", (0.0, 1e5)),
    Parameter("supply_deviation", 10000.0, "of the supply pressure, one sigma", "Pa", (0.0, 1e5)),
    Parameter(
        "state_rate",
        100.0,
        "rate of pneumaticbox/state, 100 or more for the sequencer; 0: every sample",
        "Hz",
        (0.0, 1000.0),
        read_only=False,
    ),
    Parameter("embedded_rate", 500.0, "control steps without a simulator", "Hz", (10.0, 1000.0)),
    Parameter(
        "real_time_priority", 0, "SCHED_FIFO priority of the node; 0: ordinary", bounds=(0, 99)
    ),
    Parameter(
        "embedded_seed", 0, "of noise and jitter with backend embedded", bounds=(0, 2**31 - 1)
    ),
    Parameter(
        "embedded_plant", "", "YAML file of the simulated box, or `pneumaticbox`; empty: `ideal`"
    ),
    Parameter(
        "embedded_supply",
        0.0,
        "gauge, of backend embedded; 0: that of its YAML file",
        "Pa",
        (0.0, 1e6),
        read_only=False,
    ),
    Parameter("allow_board_module", False, "run the Python module that the hardware file names"),
    ALLOW_SECOND,
    Parameter("hardware_file", "", "YAML file of the box's wiring, for backend hardware"),
)


def box_settings(value: Callable[[str], Any]) -> BoxSettings:
    """Make the box's settings from parameters, where default values come from the hand.

    Args:
        value: returns a parameter's value by its name.

    Raises:
        ValueError: a hand that does not exist, or a value that cannot be used.
    """
    channels, volumes = tuple(value("channels")), tuple(value("rest_volumes"))
    limits, model = tuple(value("pressure_limits")), value("volume_model")
    if not model:
        # the default of backend embedded is bottles
        of_hand = volumes == (0.0,) and value("backend") != "embedded"
        model = "hand" if of_hand else "fixed"
    if channels == ("",) or volumes == (0.0,) or limits == (0.0,):
        hand = load_hand(value("hand"))
        channels = hand.channels if channels == ("",) else channels
        volumes = tuple(hand.rest_volumes().tolist()) if volumes == (0.0,) else volumes
        limits = tuple(hand.max_pressures().tolist()) if limits == (0.0,) else limits
    enabled = value("start_enabled") or ("false" if value("backend") == "hardware" else "true")
    return BoxSettings(
        channels=channels,
        rest_volumes=volumes,
        pressure_limits=limits,
        control_modes=per_channel("control_mode", value("control_mode"), len(channels)),
        volume_model=model,
        hand=value("hand"),
        start_enabled=enabled == "true",
        **{name: value(name) for name in NOT_NEGATIVE},
    )


def sim_time_ignored(backend: str) -> str:
    """Warning that a backend without a simulator ignores simulated time."""
    return f"{SIM_TIME} is ignored: backend {backend} follows the wall clock"


def choose_clock(node: Node, backend: str) -> str:
    """Set use_sim_time of `node` as its backend requires.

    Backend topic follows simulated time unless the user has set the parameter; the others have no
    /clock and always follow the wall clock.

    Returns:
        A warning, or "" if there is none.
    """
    if backend == "topic":
        follow_simulated_time(node)
        return ""
    if not node.get_parameter(SIM_TIME).value:
        return ""
    node.set_parameters([rclpy.Parameter(SIM_TIME, value=False)])
    warning = sim_time_ignored(backend)
    node.get_logger().warning(warning)
    return warning
