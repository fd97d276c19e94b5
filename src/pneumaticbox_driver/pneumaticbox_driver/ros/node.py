"""The node `pneumaticbox`: topics, services and safety around the control of the air."""

from __future__ import annotations

import gc
import math
import sys
import threading
import time
import traceback
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any, cast

import numpy as np
import rclpy
from builtin_interfaces.msg import Time
from numpy.typing import NDArray
from rcl_interfaces.msg import SetParametersResult
from sensor_msgs.msg import JointState

from pneumaticbox_driver.backends.board import Board, open_board
from pneumaticbox_driver.backends.loop import DeadlineLoop, SteadyClock, set_priority
from pneumaticbox_driver.box.box import PneumaticBox
from pneumaticbox_driver.box.diagnostics import LinkState, NoteThrottle, ValveActivity, box_reports
from pneumaticbox_driver.ros.box_topics import (
    BOX_COMMAND,
    BOX_SCHEDULE,
    BOX_STATE,
    Commands,
    StateTopics,
)
from pneumaticbox_driver.ros.calibration_service import Calibrating, calibrations_of
from pneumaticbox_driver.ros.interface import HELP
from pneumaticbox_driver.ros.life_cycle import ManagedNode
from pneumaticbox_driver.ros.parameters import (
    PARAMETERS,
    box_settings,
    choose_clock,
    sim_time_ignored,
)
from pneumaticbox_driver.ros.plant_topics import (
    SENSORS,
    ClockPulse,
    Plant,
    ValvesOut,
    absolute_pressures,
)
from pneumaticbox_driver.ros.trajectory_action import TrajectoryAction
from pneumaticbox_driver.safety import SampleWatch, one_line, text_of
from pneumaticbox_driver.settings import per_channel
from softhand_common.documents.quoted import shortened
from softhand_common.numerics.compiled import compilation_announced
from softhand_ros.diagnostics import REPORT_PERIOD, Diagnostics, Preparation
from softhand_ros.executor import RoundRobin
from softhand_ros.parameters import SIM_TIME, Table, declare
from softhand_ros.run_node import run_node
from softhand_ros.services import offer_switch, offer_trigger
from softhand_ros.single import ALLOW_SECOND, Single
from softhand_ros.topics import RELIABLE, Inbox, clock_conflict, now_of, seconds

if TYPE_CHECKING:
    from pneumaticbox_driver.backends.embedded import EmbeddedBoard

# time after which the fit of a calibration, in a thread, is interrupted for the control step [s]
SWITCH_INTERVAL = 0.001
SERVE_PERIOD = 0.01  # wall time between checks for commands and services when none wait [s]
ACTION_PERIOD = 0.05  # likewise for the action, where it is offered: a check takes 1 ms [s]
SERVE_SLICE = 0.001  # longest time for them, without the last message [s]
SAMPLE_WAIT = 0.01  # longest wait for a sample before other work [s]
# attributes of parts of the box that are set by parameters of the same name
SWITCHED_PARTS = {"drift_correction": "zeroing", "leak_model": "observer"}
VALVES_PERIOD = 0.1  # between messages of unchanged valves, unless the plant is on topics [s]
DEACTIVATED = "deactivated"  # why it is vented
LAST_VALVES_TIME = 0.3  # wall time for the delivery of the last valves [s]


class PneumaticBoxNode(ManagedNode):
    """ROS node of the pneumatic box; one thread processes samples and, in between, other work.

    Args:
        plant: a simulator in this process, which calls `answer_sample`; None: the parameter backend
            says what the plant is.
        neighbours: parameters of other nodes in this process.

    Raises:
        ValueError: parameters that cannot be used.
    """

    def __init__(self, plant: Plant | None = None, neighbours: Table = ()) -> None:
        super().__init__("pneumaticbox")
        self._single = Single(self, "driver", BOX_STATE)
        declare(self, PARAMETERS, neighbours)
        self.backend, self._plant = self._value("backend"), plant
        if plant is not None and self.backend != "topic":
            raise ValueError(
                f"backend: expected topic in the process of a simulator, got {self.backend}"
            )
        settings = box_settings(self._value)
        channels = settings.channels
        calibrations = calibrations_of(self._value, len(channels))
        hardware = f"pneumaticbox/{self.backend}"
        self._diagnostics = Diagnostics(self, "pneumaticbox", hardware)
        with Preparation(self, self._diagnostics, "control") as say, compilation_announced(say):
            self.box = PneumaticBox(settings, calibrations)
        self._calibrating = Calibrating(self.box, calibrations, self._value)
        for name, part in SWITCHED_PARTS.items():
            setattr(getattr(self.box, part), name, self._value(name))
        self._single.claim(self._value(ALLOW_SECOND.name))  # before any valve can move
        self._take_priority()  # before the board is opened, as its threads inherit it
        self.board: Board | None = None
        self._vented_by_state = True  # whether to switch off is to vent
        self.connect()
        self.link = LinkState(clock_warning=choose_clock(self, self.backend))
        self.steady = SteadyClock()
        self._throttle = NoteThrottle()
        self._activity = ValveActivity(len(channels))
        self._stamp = Time()
        self._published: NDArray[np.int8] = np.zeros(len(channels), dtype=np.int8)
        self._published_at = -math.inf
        self._next_look = self._next_action = self._reported = 0.0
        self._reported_safety: tuple[bool, int] = (True, 0)  # enabled, number of vent reasons
        self._create_topics(channels)
        self._create_services()
        self.add_on_set_parameters_callback(self._on_parameters)
        self._executor = RoundRobin(self)
        self.trigger_configure()
        if settings.start_enabled:
            self.trigger_activate()
        self.get_logger().info(f"ready: {len(channels)} channels, backend {self.backend}")

    # life cycle

    def connect(self) -> None:
        """Open the board, if none is open; raises as `open_board` does."""
        if self.board is None:
            self._watch = SampleWatch()
            self._board_begin = math.nan  # of the board's clock, on the steady one [s]
            self.board = open_board(self.backend, self.box.settings, self._value)

    def switch_on(self) -> str:
        """Accept commands from now on; returns a sentence that says so. Raises ValueError while
        vented for another reason than `switch_off`.
        """
        if self.box.latch.reasons == [DEACTIVATED]:
            self.box.reset()
        return self.box.enable(True)

    def switch_off(self) -> None:
        """Stop accepting commands, and vent."""
        self.box.enable(False)
        if self._vented_by_state:
            self.box.vent(DEACTIVATED)

    def disconnect(self) -> None:
        """Vent and release the board; errors are logged."""
        self.switch_off()
        self._open_and_release()
        if self.backend != "topic":
            self._watch = SampleWatch()
            self.box.restart()

    def _open_and_release(self) -> None:
        """Open the outlets and release the board."""
        failure = self.command_vent()
        if self.board is not None:
            board, self.board = self.board, None
            try:
                board.close()
            except Exception as error:  # noqa: BLE001 boards are not ours
                failure = failure or f"the board could not be closed: {one_line(error)}"
        if failure:
            self.get_logger().error(failure)

    def _take_priority(self) -> None:
        priority = self._value("real_time_priority")
        if priority and not set_priority(priority):
            self.get_logger().warning("real_time_priority: not granted, scheduling is ordinary")

    def _value(self, name: str) -> Any:
        return self.get_parameter(name).value

    def _create_topics(self, channels: tuple[str, ...]) -> None:
        self._sensors: Inbox | None = None
        if self.backend == "topic" and self._plant is None:
            self._sensors = Inbox(self, JointState, SENSORS, RELIABLE)
        self._valves = ValvesOut(self, channels, self._plant)
        self._clock_pulse = ClockPulse(self) if self._value(SIM_TIME) else None
        rows = ("channel_deviation", "supply_deviation", "state_rate")
        self._state = StateTopics(self, self.box, *map(self._value, rows))
        handlers = {BOX_COMMAND: self.box.command, BOX_SCHEDULE: self.box.schedule_valves}
        self._commands = Commands(
            self, handlers, self._box_time, self._of_stamp, self._refuse, self._accept_command
        )
        self.link.traffic = self._commands.traffic
        times = self._box_time, self._of_stamp
        self._trajectories = TrajectoryAction(self, self.box, *times, self.link.accept)

    def _create_services(self) -> None:
        offer_switch(self, "pneumaticbox/enable", self._enable)
        calls: dict[str, Callable[[], str]] = {
            "vent": self._vent,
            "tare": self.box.tare,
            "reset": self._reset,
            "calibrate": self._calibrating.begin,
            "calibrate_next": self._calibrating.next,
        }
        for name, call in calls.items():
            offer_trigger(self, f"pneumaticbox/{name}", call)

    # time

    def _node_time(self) -> float:
        """Time for the detection of missing samples [s]: of the plant, or a monotonic clock."""
        if self.backend != "topic":
            return self.steady.now()
        return now_of(self)

    def _box_time(self) -> float:
        return self.box.time if self._watch.started else self._node_time()

    def _of_stamp(self, stamp: float) -> float:
        return stamp if self.backend == "topic" else self.steady.of_stamp(stamp)

    # messages

    def _refuse(self, reason: str) -> None:
        """Report a refused message in the log and in /diagnostics."""
        self.link.refuse(reason, time.monotonic())
        self.get_logger().warning(f"refused {reason}", throttle_duration_sec=1.0)

    def _accept_command(self) -> None:
        self._trajectories.displace("a command has come on a topic")
        self.link.accept()

    def _on_parameters(self, parameters: Sequence[rclpy.Parameter]) -> SetParametersResult:
        values = {parameter.name: parameter.value for parameter in parameters}
        try:
            self._check_change(values)
            if "control_mode" in values:
                channels = len(self.box.settings.channels)
                given = per_channel("control_mode", values["control_mode"], channels)
                self.box.set_modes(given)
        except ValueError as error:
            return SetParametersResult(successful=False, reason=str(error))
        for name in SWITCHED_PARTS & values.keys():
            setattr(getattr(self.box, SWITCHED_PARTS[name]), name, values[name])
        if "state_rate" in values:
            self._state.state_due.rate = values["state_rate"]
        if "embedded_supply" in values:
            cast("EmbeddedBoard", self.board).set_supply(values["embedded_supply"])
        return SetParametersResult(successful=True)

    def _check_change(self, values: dict[str, Any]) -> None:
        if values.get(SIM_TIME) and self.backend != "topic":
            raise ValueError(sim_time_ignored(self.backend))
        supply = values.get("embedded_supply")
        if supply is not None and self.backend != "embedded":
            raise ValueError(f"embedded_supply: expected backend embedded, got {self.backend}")
        if supply is not None:
            self.refuse_unconfigured()
        if supply == 0:
            raise ValueError("embedded_supply must be above 0 Pa while the node runs, got 0")

    def _enable(self, on: bool) -> str:
        if on:
            self.refuse_unconfigured()
        done = self.switch_on() if on else self.box.enable(False)
        self._vented_by_state = False
        try:
            self.follow(on)
        finally:
            self._vented_by_state = True
        self.link.accept()
        return done

    def _vent(self) -> str:
        self.box.vent()
        return "all outlets open until pneumaticbox/reset"

    def _reset(self) -> str:
        done = self.box.reset()
        self.link.accept()
        return done

    # samples

    def serve_samples(self, timeout: float) -> None:
        """Process the next sample of the topic backend, if one arrives within `timeout` [s], after
        the commands that arrived before it; raises RuntimeError for another backend.
        """
        if self._sensors is None:
            raise RuntimeError(f"serve_samples: expected backend topic, got {self.backend}")
        sample = self._sensors.take(timeout)
        if sample is not None:
            self.answer_sample(sample)

    def answer_sample(self, sample: JointState, commanded: bool = True) -> None:
        """Command the valves that answer a sample, after the commands that arrived before it.

        `commanded`: whether commands may have arrived; if False, they wait for `serve_others`.
        """
        if commanded:
            self._executor.serve_messages(SERVE_SLICE)
        try:
            pressures = absolute_pressures(sample, self.box.settings.channels)
        except ValueError as error:
            self._refuse(f"{SENSORS}: {error}")
            return
        stamp = sample.header.stamp
        self._publish_answer(stamp, self.box.on_sample(seconds(stamp), pressures), pressures)

    def serve_board(self, board: Board) -> None:
        """Read and command the board; an error of the board vents."""
        try:
            pressures = board.read()
            if math.isnan(self._board_begin):
                self._board_begin = self.steady.now() - board.time
            stamp = self.get_clock().now().to_msg()
            valves = self.box.on_sample(self._board_begin + board.time, pressures)
            board.command(valves)
            self._publish_answer(stamp, valves, pressures)
        except (ValueError, OSError) as error:
            self._fault(f"backend {self.backend}: {shortened(text_of(error))}")
        except Exception as error:  # noqa: BLE001 boards are not ours
            self._break_down(f"backend {self.backend}", error)

    def _publish_answer(
        self, stamp: Time, valves: NDArray[np.int8], pressures_abs: NDArray[np.float64]
    ) -> None:
        """Publish the answer to a sample, stamped by the node's clock, and what was estimated.

        `pressures_abs` are absolute, of the channels, then of the supply (n + 1,) [Pa].
        """
        self._stamp = stamp
        self._answer(stamp, valves)
        self._watch.note(self._node_time(), time.monotonic())
        self.link.samples += 1
        self._state.publish(stamp, pressures_abs)
        self._trajectories.look(stamp)

    def _answer(self, stamp: Time, valves: NDArray[np.int8]) -> None:
        """Publish the valves: for a plant on topics always, otherwise only changes."""
        now = time.monotonic()
        known = now - self._published_at < VALVES_PERIOD and (valves == self._published).all()
        if self.backend != "topic" and known:
            return
        self._published, self._published_at = valves, now
        self._valves.answer(stamp, valves)

    # other work

    def serve_others(self, slack: float) -> None:
        """Serve commands, services and parameters, watch the sensors and report, when due.

        Args:
            slack: longest time for that [s].
        """
        now = time.monotonic()
        if now < self._next_look:
            return
        more = self._executor.serve(min(SERVE_SLICE, slack))
        self._next_look = now if more else now + SERVE_PERIOD
        if self._trajectories.offered and now >= self._next_action:
            self._next_action = now + ACTION_PERIOD
            self._executor.serve_rest()
        self._watch_sensors(now)
        self._calibrating.look()
        self._activity.note(self.box.time, self.box.openings)
        safety = self.box.enabled, len(self.box.latch.reasons)
        if now - self._reported >= REPORT_PERIOD or safety != self._reported_safety:
            for reason in self.box.latch.reasons[self._reported_safety[1] :]:
                self.get_logger().error(
                    f"{reason}: venting until the service pneumaticbox/reset is called"
                )
            self._reported, self._reported_safety = now, safety
            self._executor.serve_rest()
            self._report(now)
            gc.collect(1)

    def _watch_sensors(self, now: float) -> None:
        if self._clock_pulse is not None:
            self._clock_pulse.look(now)
            self.link.paused = self._clock_pulse.paused(now)
            self.link.clock_stands = self._clock_pulse.stands(now)
        self.link.sensors_seen = self._watch.started
        simulated = self._clock_pulse is not None
        reason = self._watch.silence(self._node_time(), now, simulated)
        if reason is not None:
            self._fault(reason)

    def _fault(self, reason: str) -> None:
        """Vent for a fault outside of the box, until there are samples and a reset."""
        self.box.sensors_sound = False
        if reason not in self.box.latch.reasons:
            self.box.vent(reason)
            failure = self.command_vent()
            if failure:
                self.box.vent(failure)

    def keep_serving(self, what: str, step: Callable[[float], None], time_left: float) -> None:
        """Run a `step` of the loop in the `time_left` [s]; any error in it vents the box."""
        try:
            step(time_left)
        except Exception as error:  # noqa: BLE001 any error must vent, and services continue
            self._break_down(what, error)

    def _break_down(self, what: str, error: Exception) -> None:
        """Vent for an unexpected error; the first time its traceback is logged."""
        reason = f"{what}: {one_line(error)}"
        if reason not in self.box.latch.reasons:
            lines = "".join(traceback.format_tb(error.__traceback__))
            self.get_logger().error(f"{reason}\n{lines}", throttle_duration_sec=5.0)
        self._fault(reason)

    def command_vent(self) -> str:
        """Command all outlets open now, not in answer to a sample: first the board, then the topic.

        Returns:
            Why the board cannot be commanded; "" when it was.
        """
        valves = np.full(len(self.box.settings.channels), -1, dtype=np.int8)
        untold = ""
        if self.board is not None:
            try:
                self.board.command(valves)
            except Exception as error:  # noqa: BLE001 boards are not ours
                untold = (
                    f"the board does not open the outlets, shut off the supply: {one_line(error)}"
                )
        try:
            self._valves.answer(self._stamp, valves)
        except Exception as error:  # noqa: BLE001 the node goes on to watch the board
            self.get_logger().error(f"pneumaticbox/valves: not published: {one_line(error)}")
        return untold

    def close(self) -> None:
        """Open the outlets, release the board and destroy the node."""
        self._open_and_release()
        self._valves.flush(LAST_VALVES_TIME)
        self._executor.close()
        self.destroy_node()

    def _report(self, now: float) -> None:
        for note in self._throttle.due(self.box.notes, now):
            self.get_logger().warning(note)
        self.box.notes.clear()
        self.link.forget_refused(now)
        if self.backend == "topic":
            self.link.simulators = self.count_publishers(self.resolve_topic_name(SENSORS))
        self.link.second = self._single.warning()
        if self._clock_pulse is not None:
            self.link.clock_warning = clock_conflict(self)
        self._commands.count_commanders()
        self.link.storm = self._commands.traffic.storm(now)
        reports = box_reports(self.box, self.link, self._activity)
        self._diagnostics.publish([*reports, self._calibrating.report()])


def run_topic(node: PneumaticBoxNode, stop: threading.Event) -> None:
    """Process the samples of the topic backend until `stop` is set."""
    while not stop.is_set():
        node.keep_serving("sample", node.serve_samples, SAMPLE_WAIT)
        node.keep_serving("service", node.serve_others, SERVE_SLICE)


def run_board(node: PneumaticBoxNode, stop: threading.Event) -> None:
    """Read and command the board, while there is one, at the rate of the parameter embedded_rate
    until `stop` is set.
    """
    loop = DeadlineLoop(1 / node.get_parameter("embedded_rate").value)

    def step() -> None:
        if node.board is not None:
            node.serve_board(node.board)
        node.keep_serving("service", node.serve_others, loop.slack)

    loop.run(step, stop)


def prepare_process() -> None:
    """Set up this process so that neither garbage collection nor other threads delay a sample; see
    `serve_others`.
    """
    sys.setswitchinterval(SWITCH_INTERVAL)
    gc.disable()


def run(node: PneumaticBoxNode, stop: threading.Event) -> None:
    """Control the box until `stop` is set."""
    prepare_process()
    if node.backend == "topic":
        run_topic(node, stop)
    else:
        run_board(node, stop)


def main(args: list[str] | None = None) -> int:
    """Run the node; returns the exit status of `run_node`."""
    return run_node(
        "pneumaticbox",
        PneumaticBoxNode,
        run,
        usage=HELP,
        args=args,
        closing_time=lambda node: getattr(node.board, "vent_time", 0.0),
    )


if __name__ == "__main__":
    sys.exit(main())
