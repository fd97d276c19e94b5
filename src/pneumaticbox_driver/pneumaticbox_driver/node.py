"""The node `pneumaticbox`: air mass control of the channels, its services and its safety."""

from __future__ import annotations

import array
import gc
import signal
import sys
import threading
import time
from collections.abc import Callable
from types import FrameType
from typing import Any

import numpy as np
import rclpy
from builtin_interfaces.msg import Time
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from numpy.typing import NDArray
from rcl_interfaces.msg import SetParametersResult
from rclpy.exceptions import ParameterException
from rclpy.executors import SingleThreadedExecutor, TimeoutException
from rclpy.node import Node
from rclpy.signals import SignalHandlerOptions
from sensor_msgs.msg import FluidPressure, JointState
from std_srvs.srv import SetBool, Trigger
from trajectory_msgs.msg import JointTrajectory

from pneumaticbox_driver.backends.embedded import EmbeddedBench
from pneumaticbox_driver.backends.topic.node import RELIABLE, ClockPulse, SampleFeed
from pneumaticbox_driver.box import PneumaticBox
from pneumaticbox_driver.calibration import load_calibration
from pneumaticbox_driver.commands import TrajectoryPoint
from pneumaticbox_driver.controllers import check_mode
from pneumaticbox_driver.deadline_loop import DeadlineLoop
from pneumaticbox_driver.diagnostics import LinkState, box_reports
from pneumaticbox_driver.node_setup.node import (
    SIM_TIME,
    SIM_TIME_IGNORED,
    choose_clock,
    declare_parameters,
)
from pneumaticbox_driver.note_throttle import NoteThrottle
from pneumaticbox_driver.parameters import box_settings, check_backend
from pneumaticbox_driver.priority import set_priority
from pneumaticbox_driver.safety import SampleWatch
from pneumaticbox_driver.settings import per_channel

SERVE_PERIOD = 0.01  # wall time between looks at commands and services [s]
REPORT_PERIOD = 1.0  # wall time between diagnostics (REP-107) [s]
FAREWELL = 0.3  # wall time for the last valves to arrive [s]
PRESSURE_RATE = 50.0  # of the FluidPressure topics [Hz]


def _seconds(stamp: Time) -> float:
    return stamp.sec + 1e-9 * stamp.nanosec


def _points(message: JointTrajectory) -> list[TrajectoryPoint]:
    return [
        TrajectoryPoint(
            point.time_from_start.sec + 1e-9 * point.time_from_start.nanosec,
            point.positions,
            point.velocities,
            point.effort,
        )
        for point in message.points
    ]


class PneumaticBoxNode(Node):
    """ROS around the pneumatic box; one thread answers samples and serves the rest in between."""

    def __init__(self) -> None:
        super().__init__("pneumaticbox")
        declare_parameters(self)
        self.backend = check_backend(self._value("backend"))
        settings = box_settings(self._value)
        channels = settings.channels
        calibration = load_calibration(self._value("calibration_file") or None, len(channels))
        self.box = PneumaticBox(settings, calibration)
        self.link = LinkState(clock_warning=choose_clock(self, self.backend))
        self._throttle = NoteThrottle()
        self._watch = SampleWatch()
        self._stamp = Time()
        self._served = self._reported = 0.0
        self._create_topics(channels)
        self._create_services()
        self._take_priority()
        self.add_on_set_parameters_callback(self._on_parameters)
        self._executor = SingleThreadedExecutor(context=self.context)
        self._executor.add_node(self)

    def _take_priority(self) -> None:
        priority = self._value("real_time_priority")
        if priority and not set_priority(priority):
            self.get_logger().warning("real_time_priority: not granted, scheduling is ordinary")

    def _value(self, name: str) -> Any:
        return self.get_parameter(name).value

    def _create_topics(self, channels: tuple[str, ...]) -> None:
        self._feed = SampleFeed(self, channels)
        self._clock_pulse = ClockPulse(self) if self._value(SIM_TIME) else None
        self._state_out = self.create_publisher(JointState, "pneumaticbox/state", RELIABLE)
        self._state = JointState(name=list(channels))
        names = (*channels, "supply")
        self._pressure_out = [
            self.create_publisher(FluidPressure, f"pneumaticbox/{name}/pressure", RELIABLE)
            for name in names
        ]
        deviations = [self._value("channel_deviation")] * len(channels)
        deviations.append(self._value("supply_deviation"))
        self._pressure = [FluidPressure(variance=deviation**2) for deviation in deviations]
        for message, name in zip(self._pressure, names, strict=True):
            message.header.frame_id = name
        self._pressure_slot = 0
        self._diagnostics = self.create_publisher(DiagnosticArray, "/diagnostics", RELIABLE)
        self.create_subscription(
            JointTrajectory, "pneumaticbox/command", self._on_command, RELIABLE
        )
        self.create_subscription(
            JointTrajectory, "pneumaticbox/valve_schedule", self._on_valve_schedule, RELIABLE
        )

    def _create_services(self) -> None:
        self.create_service(SetBool, "pneumaticbox/enable", self._on_enable)
        calls: dict[str, Callable[[], str]] = {
            "vent": self._vent,
            "tare": self.box.tare,
            "reset": self._reset,
            "calibrate": self._calibrate,
            "calibrate_next": self._calibrate,
        }
        for name, call in calls.items():
            self.create_service(Trigger, f"pneumaticbox/{name}", _answering(call))

    # what comes in

    def _refuse(self, reason: str) -> None:
        """Name a message that cannot be used, in the log and in /diagnostics; it has no effect."""
        self.link.refuse(reason, time.monotonic())
        self.get_logger().warning(f"refused {reason}", throttle_duration_sec=1.0)

    def _on_command(self, message: JointTrajectory) -> None:
        now = self.box.time if self._watch.started else self._node_time()
        stamp = _seconds(message.header.stamp)
        try:
            self.box.command(message.joint_names, _points(message), stamp, now)
        except ValueError as error:
            self._refuse(f"pneumaticbox/command: {error}")
        else:
            self.link.refused = ""

    def _on_valve_schedule(self, _: JointTrajectory) -> None:
        modes = list(self.box.settings.control_modes)
        self._refuse(
            f"pneumaticbox/valve_schedule: control_mode: expected 'time', which is not available "
            f"yet, got {modes}"
        )

    def _on_parameters(self, parameters: list[rclpy.Parameter]) -> SetParametersResult:
        for parameter in parameters:
            if parameter.name == SIM_TIME and parameter.value and self.backend == "embedded":
                return SetParametersResult(successful=False, reason=SIM_TIME_IGNORED)
            if parameter.name != "control_mode":
                continue
            try:
                given = per_channel(parameter.name, parameter.value, len(self.box.guard.limits))
                for mode in given:
                    check_mode(mode)
            except ValueError as error:
                return SetParametersResult(successful=False, reason=str(error))
        return SetParametersResult(successful=True)

    def _on_enable(self, request: SetBool.Request, response: SetBool.Response) -> SetBool.Response:
        return _answer(lambda: self._enable(request.data), response)

    def _enable(self, on: bool) -> str:
        done = self.box.enable(on)
        self.link.refused = ""
        return done

    def _vent(self) -> str:
        self.box.vent()
        return "all outlets open until pneumaticbox/reset"

    def _reset(self) -> str:
        done = self.box.reset()
        self.link.refused = ""
        return done

    def _calibrate(self) -> str:
        if not self._value("calibration_volume") > 0:
            raise ValueError("calibration_volume must be above 0 m3: no fixed volume is attached")
        raise ValueError(
            "calibration over ROS is not available yet; the command `calibrate` makes a file for "
            "the parameter calibration_file"
        )

    # samples

    def serve_samples(self, timeout: float) -> None:
        """Answer the next sample of the topic backend, if one comes within `timeout` [s]."""
        sample = self._feed.take(timeout)
        if sample is None:
            return
        try:
            pressures = self._feed.pressures(sample)
        except ValueError as error:
            self._refuse(f"pneumaticbox/sensors: {error}")
            return
        self.on_sample(sample.header.stamp, pressures)

    def on_sample(self, stamp: Time, pressures: NDArray[np.float64]) -> NDArray[np.int8]:
        """Answer a sample: absolute pressures of the channels, then the supply (n + 1,) [Pa]."""
        valves = self.box.on_sample(_seconds(stamp), pressures)
        self._stamp = stamp
        self._feed.answer(stamp, valves)
        self._watch.heard(self._node_time(), time.monotonic())
        self.link.samples += 1
        self._publish_state(stamp)
        self._publish_pressures(stamp, pressures)
        return valves

    def _publish_state(self, stamp: Time) -> None:
        state, box = self._state, self.box
        state.header.stamp = stamp
        state.position = array.array("d", box.observer.mass.tolist())
        state.velocity = array.array("d", box.observer.flow.tolist())
        state.effort = array.array("d", box.gauge.tolist())
        self._state_out.publish(state)

    def _publish_pressures(self, stamp: Time, pressures: NDArray[np.float64]) -> None:
        """Publish the sensors in turn, each at its rate, spread over the samples."""
        n = len(self._pressure)
        slot = int(_seconds(stamp) * PRESSURE_RATE * n)
        for turn in range(max(self._pressure_slot + 1, slot - n + 1), slot + 1):
            message = self._pressure[turn % n]
            message.header.stamp = stamp
            message.fluid_pressure = float(pressures[turn % n])
            self._pressure_out[turn % n].publish(message)
        self._pressure_slot = slot

    # everything else

    def serve_others(self) -> None:
        """Serve commands, services and parameters, watch the sensors, report: when it is time."""
        now = time.monotonic()
        if now - self._served < SERVE_PERIOD:
            return
        self._served = now
        self._serve_ready()
        self._watch_sensors(now)
        if now - self._reported >= REPORT_PERIOD:
            self._reported = now
            self._report(now)
            gc.collect(1)

    def _serve_ready(self) -> None:
        end = time.monotonic() + SERVE_PERIOD
        while time.monotonic() < end:
            try:
                task, _, _ = self._executor.wait_for_ready_callbacks(timeout_sec=0)
            except TimeoutException:
                return
            task()
            error = task.exception()
            if error is not None:
                raise error

    def _watch_sensors(self, now: float) -> None:
        if self._clock_pulse is not None:
            self._clock_pulse.look(now)
            self.link.paused = self._clock_pulse.paused(now)
            self.link.clock_stands = self._clock_pulse.stands(now)
        self.link.sensors_seen = self._watch.started
        reason = self._watch.silence(self._node_time(), now, self.link.paused)
        if reason is not None and reason not in self.box.latch.reasons:
            self.box.vent(reason)
            self.box.sensors_sound = False
            self.get_logger().error(f"{reason}: venting until pneumaticbox/reset")
            self.command_vent()

    def command_vent(self) -> None:
        """Publish open outlets at once, without a sample to answer."""
        self._feed.answer(self._stamp, np.full(len(self.box.settings.channels), -1, dtype=np.int8))

    def close(self) -> None:
        """Leave the outlets open and go."""
        self.command_vent()
        self._feed.flush(FAREWELL)
        self.destroy_node()

    def _report(self, now: float) -> None:
        for note in self._throttle.due(self.box.notes, now):
            self.get_logger().warning(note)
        self.box.notes.clear()
        self.link.forget_refused(now)
        if self.backend == "topic":
            self.link.simulators = self._feed.publishers()
        message = DiagnosticArray()
        message.header.stamp = self.get_clock().now().to_msg()
        for report in box_reports(self.box, self.link):
            pairs = [KeyValue(key=key, value=value) for key, value in report.values.items()]
            status = DiagnosticStatus(name=f"pneumaticbox: {report.name}", values=pairs)
            status.level = bytes([report.level])
            status.message, status.hardware_id = report.message, f"pneumaticbox/{self.backend}"
            message.status.append(status)
        self._diagnostics.publish(message)

    def _node_time(self) -> float:
        return self.get_clock().now().nanoseconds * 1e-9


def _answering(call: Callable[[], str]) -> Callable[..., Trigger.Response]:
    """Callback of a Trigger service: the call's sentence, or why it was refused."""

    def answer(_: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        return _answer(call, response)

    return answer


def _answer(call: Callable[[], str], response: Any) -> Any:
    """Fill the response of a Trigger or SetBool service from `call`."""
    try:
        response.message = call()
        response.success = True
    except ValueError as error:
        response.message, response.success = str(error), False
    return response


def run_topic(node: PneumaticBoxNode, stop: threading.Event) -> None:
    """Answer the samples of the topic backend until `stop` is set."""
    while not stop.is_set():
        node.serve_samples(SERVE_PERIOD)
        node.serve_others()


def run_embedded(
    node: PneumaticBoxNode, stop: threading.Event, loop: DeadlineLoop | None = None
) -> None:
    """Run the box on bottles of the hand's rest volumes, on the node's clock, until `stop`.

    `loop` gives the rate; None takes that of the parameter embedded_rate.
    """
    settings = node.box.settings
    seed = node.get_parameter("embedded_seed").value
    bench = EmbeddedBench(settings.channels, settings.rest_volumes, seed=seed)
    loop = loop or DeadlineLoop(1 / node.get_parameter("embedded_rate").value)
    last = time.monotonic() - loop.period

    def step() -> None:
        """Let the bottles run up to now and the box answer."""
        nonlocal last
        now = time.monotonic()
        pressures = bench.advance(min(now - last, 10 * loop.period))
        last = now
        bench.command(node.on_sample(node.get_clock().now().to_msg(), pressures))
        node.serve_others()

    loop.run(step, stop)


def main(args: list[str] | None = None) -> int:
    """Run the node until SIGINT or SIGTERM; 0 then, 2 for parameters that cannot be used."""
    rclpy.init(args=args, signal_handler_options=SignalHandlerOptions.NO)
    stop = threading.Event()

    def end(_: int, __: FrameType | None) -> None:
        stop.set()

    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, end)
    node, status = None, 0
    try:
        node = PneumaticBoxNode()
        gc.freeze()
        gc.disable()  # a collection would come in the middle of a sample; see serve_others
        (run_embedded if node.backend == "embedded" else run_topic)(node, stop)
    except (ValueError, ParameterException) as error:
        print(f"pneumaticbox: {error}", file=sys.stderr)
        status = 2
    finally:
        for number in (signal.SIGINT, signal.SIGTERM):
            signal.signal(number, signal.SIG_IGN)
        if node is not None:
            node.close()
        rclpy.try_shutdown()
    return status


if __name__ == "__main__":
    sys.exit(main())
