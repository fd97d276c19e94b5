"""Valve boards that fail while a valve inflates: told to open in time, ended, in use again.

The simulated board of test/support/valve_board.py is a process with gas physics of its own; the
driver, a process too, uses it by the shipped examples/valve_boards/text_board.py.

Latency: from the fault, as the board notes it, to the arrival of valves that open all outlets at
the board's end of the line, whether its firmware obeys or not. For `restart` it counts from when
the board takes connections again: nothing arrives before, and its valves are closed meanwhile.
"""

from __future__ import annotations

import os
import signal
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from board_process import EXAMPLES, LINKS, BoardProcess
from builtin_interfaces.msg import Duration
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint
from valve_board import FAULTS

from bench.robust.rig import START_LIMIT, Rig, RigError, launched
from bench.row import at_least, at_most, stated
from pneumaticbox_driver.modes import MODES
from softhand_bringup.processes.launcher import NodeCommand

TAKES = "7 min"
MODULE = "pneumaticbox_driver.ros.node"
CHANNELS = ["a", "b"]
HAND = "rbo_hand_1_split"  # whose volumes the board has in mode volume, see ACTUATORS
ACTUATORS = ("--volumes", "9.7e-6", "3.8e-6", "--swelling", "1.2e-5")
BOTTLES = ("--volumes", "1e-4", "1e-4")
TARGETS = {"mass": 9e-5, "mass_flow": 2e-5, "pressure": 9e4, "volume": 8e-6, "time": 1.0}
TOLD_LIMIT, OPEN_LIMIT, END_LIMIT = 250.0, 5.0, 2.0  # [ms], [s], [s]
EMPTYING = 1.5  # for the chambers to empty, vented [s]
STAYS = 0.3  # for which the outlets must stay open to count as vented [s]
FILL_LIMIT = 20.0  # for an inlet that opens [s]
SAFETY = "pneumaticbox: safety"


@dataclass
class Case:
    """A fault on a board: latency [ms], infinite where it was never told, and recovery."""

    link: str
    mode: str
    fault: str
    latency: float = float("inf")
    told: str = ""
    recovered: bool = False


def run() -> list[dict[str, Any]]:
    """Rows on the latency, on the end by SIGTERM and on the recovery."""
    cases: list[Case] = []
    ends: list[float] = []
    for number, (link, mode) in enumerate((link, mode) for link in LINKS for mode in MODES):
        print(f"  {link}, mode {mode}", flush=True)
        with _driver(link, mode) as (rig, board):
            for fault in FAULTS:
                cases.append(examine(rig, board, Case(link, mode, fault)))
                print(f"    {_line(cases[-1])}", flush=True)
            ends.append(end(rig, board, mode, FAULTS[number % len(FAULTS)]))
    return rows(cases, ends)


def rows(cases: list[Case], ends: list[float]) -> list[dict[str, Any]]:
    """What was measured, by fault and in all."""
    found = []
    for fault in FAULTS:
        worst = max(case.latency for case in cases if case.fault == fault)
        found.append(at_most(f"{fault}: worst latency to outlets told", worst, "ms", TOLD_LIMIT))
    latencies = [case.latency for case in cases]
    return [
        stated("faults, over TCP and serial, in each control mode", len(cases), ""),
        *found,
        stated("median latency", float(np.median(latencies)), "ms"),
        at_most("worst latency from fault to outlets told", max(latencies), "ms", TOLD_LIMIT),
        at_most("worst end after SIGTERM during a fault", max(ends), "s", END_LIMIT),
        at_least("in use again after reset", sum(c.recovered for c in cases), "", len(cases)),
    ]


def _line(case: Case) -> str:
    again = "in use again" if case.recovered else "NOT in use again"
    return f"{case.fault:8s} {case.latency:6.0f} ms  {again}  {case.told:.90}"


@contextmanager
def _driver(link: str, mode: str) -> Iterator[tuple[Rig, BoardProcess]]:
    """A driver in a mode on a board, whose channels are averaged."""
    with tempfile.TemporaryDirectory() as name:
        options = ACTUATORS if mode == "volume" else BOTTLES
        before = os.environ.get("PYTHONPATH", "")
        with BoardProcess(link, Path(name), options=options) as board:
            os.environ["PYTHONPATH"] = os.pathsep.join(filter(None, [str(EXAMPLES), before]))
            try:
                with launched([NodeCommand("driver", MODULE, _parameters(board, mode))]) as rig:
                    rig.need(lambda: SAFETY in rig.told, START_LIMIT, "a driver's diagnostics")
                    yield rig, board
            finally:
                os.environ["PYTHONPATH"] = before


def _parameters(board: BoardProcess, mode: str) -> dict[str, Any]:
    of_mode: dict[str, Any] = {"rest_volumes": [1e-4, 1e-4]}
    if mode == "volume":
        of_mode = {"hand": HAND, "volume_model": "hand", "rest_volumes": [0.0]}
    return {
        "backend": "hardware",
        "start_enabled": True,
        "hardware_file": str(board.hardware_file),
        "allow_board_module": True,
        "use_sim_time": False,
        "channels": CHANNELS,
        "pressure_limits": [1e5, 1e5],
        "control_mode": [mode],
        **of_mode,
    }


def command(rig: Rig, mode: str, target: float) -> None:
    """Ask both channels for a target from now on."""
    topic = "valve_schedule" if MODES[mode].scheduled else "command"
    publisher = rig.node.create_publisher(JointTrajectory, f"pneumaticbox/{topic}", 10)
    rig.need(publisher.get_subscription_count, 10.0, f"a driver that listens to {topic}")
    values = {MODES[mode].field: [target] * 2}
    points = [JointTrajectoryPoint(**values)]
    if MODES[mode].scheduled:
        points.append(JointTrajectoryPoint(positions=[0.0] * 2, time_from_start=Duration(sec=20)))
    publisher.publish(JointTrajectory(joint_names=CHANNELS, points=points))
    rig.spin(0.05)
    rig.node.destroy_publisher(publisher)


def inflate(rig: Rig, board: BoardProcess, mode: str) -> None:
    """Leave any safe state, and command air until an inlet is told to open.

    Raises:
        RigError: it was not.
    """
    finish = time.monotonic() + FILL_LIMIT
    while time.monotonic() < finish:
        rig.call("pneumaticbox/reset")
        rig.call("pneumaticbox/tare")
        command(rig, mode, TARGETS[mode])
        if rig.wait(lambda: board.inflating, 1.0):
            return
    raise RigError(f"no inlet was opened; told: {rig.told.get(SAFETY)}")


def examine(rig: Rig, board: BoardProcess, case: Case) -> Case:
    """Let a fault happen while an inlet is open, and use the board again afterwards."""
    inflate(rig, board, case.mode)
    begun = board.switch(case.fault)
    rig.wait(lambda: board.opened is not None and board.opened > begun, OPEN_LIMIT)
    rig.wait(lambda: rig.told.get(SAFETY, (0, ""))[0] == 2, OPEN_LIMIT)
    rig.spin(STAYS)
    opened, up = board.opened, board.last("up", begun)
    if opened is not None and opened > begun:
        case.latency = 1e3 * (opened - (begun if up is None else up.time))
    case.told = rig.told[SAFETY][1].removeprefix("vented until pneumaticbox/reset: ")
    board.switch("none")
    rig.spin(EMPTYING)
    try:
        inflate(rig, board, case.mode)
        case.recovered = True
    except RigError as error:
        case.told = f"{case.told}; afterwards: {error}"
    return case


def end(rig: Rig, board: BoardProcess, mode: str, fault: str) -> float:
    """Time from SIGTERM, while a fault lasts, to the end of the driver's process [s]."""
    inflate(rig, board, mode)
    board.switch(fault)
    rig.spin(0.5)
    begun = time.monotonic()
    rig.nodes["driver"].send(signal.SIGTERM)
    code = rig.nodes["driver"].wait(20.0)
    spent = time.monotonic() - begun
    print(f"    SIGTERM during {fault}: status {code} after {spent:.2f} s", flush=True)
    return spent if code == 0 else float("inf")
