"""Client of the driver for scripts: configure, run, schedule, monitor, stop.

from pneumaticbox_driver.ros.client import PneumaticboxClient

with PneumaticboxClient() as box:
    box.configure(control_mode="mass")
    box.run({"a": 2e-5}, times=1.0)
    for state in box.monitor(2.0):
        print(state.time, state.mass["a"], state.pressure["a"])
    box.stop()
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from builtin_interfaces.msg import Duration
from diagnostic_msgs.msg import DiagnosticArray
from rcl_interfaces.srv import GetParameters, SetParametersAtomically
from rclpy.client import Client
from rclpy.parameter import Parameter, parameter_value_to_python
from sensor_msgs.msg import JointState
from std_srvs.srv import SetBool, Trigger
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

from pneumaticbox_driver.modes import MODES as CONTROL_MODES
from softhand_ros.client_link import ClientLink
from softhand_ros.parameters import SIM_TIME
from softhand_ros.topics import full_name, seconds, stamp_of_seconds

MODE_PARAMETER = "control_mode"
QUEUED_STATES = 5000  # for `monitor`, 10 s at 500 Hz
REPEAT_PERIOD = 1.0  # of the box's time, between repetitions of a reached target [s]
TRIGGERS = ("vent", "tare", "reset", "calibrate", "calibrate_next")
BOX_COMMAND, BOX_SCHEDULE = "pneumaticbox/command", "pneumaticbox/valve_schedule"


class PneumaticboxError(RuntimeError):
    """The box refuses a request, has vented or does not answer; the message gives the reason."""


@dataclass(frozen=True)
class BoxState:
    """State of the box at one sample, by channel.

    `time` is the stamp [s], `mass` the estimate above the air mass at rest [kg], `flow` that into
    the channel [kg/s], `pressure` the gauge pressure [Pa].
    """

    time: float
    mass: Mapping[str, float]
    flow: Mapping[str, float]
    pressure: Mapping[str, float]


@dataclass(frozen=True)
class Diagnosis:
    """A status of `/diagnostics`: level (0 OK, 1 warning, 2 error), sentence, figures."""

    level: int
    message: str
    values: Mapping[str, str]


class Complaints:
    """Finds errors for the user of a client in the diagnostics of the driver.

    These are a vent that the user has not requested, and refused messages.
    """

    def __init__(self) -> None:
        self.vent_wanted = False
        self._refusals: int | None = None

    def of(self, diagnoses: Mapping[str, Diagnosis]) -> str:
        """The error in the newest diagnoses, given by name; "" for none."""
        safety, commands = diagnoses.get("safety"), diagnoses.get("commands")
        refused = "" if commands is None else self._refused(commands)
        if safety is not None and safety.level > 1 and not self.vent_wanted:
            return safety.message
        return refused

    def forget_refusals(self) -> None:
        """Ignore messages that are refused before the next diagnosis."""
        self._refusals = None

    def _refused(self, commands: Diagnosis) -> str:
        count = int(commands.values.get("refused messages", 0))
        new = self._refusals is not None and count > self._refusals
        self._refusals = count
        return commands.message if new and commands.level > 0 else ""


class PneumaticboxClient:
    """Client of one driver; a context manager. It receives messages only during its calls.

    Args:
        patience: longest time for the discovery and for an answer of the driver [s].
        domain: ROS domain; None for ROS_DOMAIN_ID of the environment.
        name: name of the client's node.
        namespace: namespace of the driver; empty: the root.

    Raises:
        PneumaticboxError: no driver is found.
    """

    def __init__(
        self,
        patience: float = 10.0,
        domain: int | None = None,
        name: str = "pneumaticbox_client",
        namespace: str = "",
    ) -> None:
        self._link, self._patience = ClientLink(name, domain, namespace), patience
        # how the driver's names in /diagnostics begin
        self._prefix = f"{full_name(self._link.node, 'pneumaticbox')}: "
        self._states: deque[BoxState] = deque(maxlen=QUEUED_STATES)
        self._state: BoxState | None = None
        self._complaints = Complaints()
        self._complaint = ""
        self._modes: tuple[str, ...] = ()
        self._held: dict[str, tuple[float, float]] = {}  # by channel: target, time it is due [s]
        self._repeated = -math.inf  # time of the last repetition [s]
        self.diagnostics: dict[str, Diagnosis] = {}  # newest, by name: safety, channel a ...
        try:
            self._connect()
        except BaseException:
            self.close()
            raise

    def __enter__(self) -> PneumaticboxClient:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Destroy the client's node; the box continues with its last commands."""
        self._link.close()

    def _connect(self) -> None:
        link, node, wait = self._link, self._link.node, self._wait
        link.listen(JointState, "pneumaticbox/state", self._on_state, depth=1000)
        link.listen(DiagnosticArray, "/diagnostics", self._on_diagnostics, depth=50)
        self._out = {
            topic: node.create_publisher(JointTrajectory, topic, 10)
            for topic in (BOX_COMMAND, BOX_SCHEDULE)
        }
        kinds = dict.fromkeys(TRIGGERS, Trigger)
        kinds |= {"enable": SetBool, "get_parameters": GetParameters}
        kinds["set_parameters_atomically"] = SetParametersAtomically
        self._clients = {
            name: link.client(kind, f"pneumaticbox/{name}") for name, kind in kinds.items()
        }
        wait(lambda: self._state is not None, "no driver publishes pneumaticbox/state")
        wait(lambda: "safety" in self.diagnostics, "the driver does not report itself")
        everyone = self._out.values()
        wait(lambda: all(p.get_subscription_count() for p in everyone), "no driver listens")
        modes, simulated = self._parameters(MODE_PARAMETER, SIM_TIME)
        self._modes = self._spread(modes)
        link.follow_simulated_time(simulated)

    def _wait(self, condition: Callable[[], Any], silence: str) -> None:
        """Receive messages until a condition holds; `silence` is the error when it does not."""
        if not self._link.wait(condition, self._patience):
            self._raise_complaint()
            raise PneumaticboxError(f"{silence} (waited {self._patience:g} s)")

    def _call(self, name: str, request: Any) -> Any:
        """Answer of a service of the driver."""
        client: Client = self._clients[name]
        self._wait(client.service_is_ready, f"no driver offers {client.srv_name}")
        answer = self._link.ask(client, request, self._patience)
        if answer is None:
            raise PneumaticboxError(
                f"{client.srv_name} does not answer (waited {self._patience:g} s)"
            )
        return answer

    # state of the box

    @property
    def channels(self) -> tuple[str, ...]:
        """Names of the channels, in the order of the outlets."""
        return tuple(self.state.mass)

    @property
    def modes(self) -> dict[str, str]:
        """Control modes by channel, as set or read by this client."""
        return dict(zip(self.channels, self._modes, strict=True))

    @property
    def state(self) -> BoxState:
        """The latest state; raises PneumaticboxError before the first one."""
        self._link.drain()
        if self._state is None:
            raise PneumaticboxError("no driver publishes pneumaticbox/state")
        return self._state

    @property
    def now(self) -> float:
        """Present time of the driver's clock, simulated or not [s]."""
        self._link.drain()
        return self._link.now

    def monitor(self, duration: float = math.inf) -> Iterator[BoxState]:
        """Yield all states for `duration` [s] of the box's time; repeats targets (`keep_alive`).

        Raises:
            PneumaticboxError: the box has vented without request, refused a message, or publishes
                no more states.
        """
        self._link.drain()
        self._states.clear()
        end = math.nan
        while True:
            self._wait(lambda: self._states, "the driver has fallen silent")
            self._raise_complaint()
            self.keep_alive()
            while self._states:
                state = self._states.popleft()
                end = state.time + duration if math.isnan(end) else end
                if state.time > end:
                    return
                yield state

    # commands

    def configure(self, **parameters: Any) -> None:
        """Set parameters of the driver, all of them or none.

        `control_mode` is one mode for all channels, or a list, or modes by channel; others stay.

        Raises:
            PneumaticboxError: the driver refuses one; the message says why.
        """
        if MODE_PARAMETER in parameters:
            parameters[MODE_PARAMETER] = list(self._spread(parameters[MODE_PARAMETER]))
        values = [Parameter(name, value=value) for name, value in parameters.items()]
        request = SetParametersAtomically.Request(
            parameters=[value.to_parameter_msg() for value in values]
        )
        answer = self._call("set_parameters_atomically", request)
        if not answer.result.successful:
            raise PneumaticboxError(answer.result.reason)
        before, self._modes = self.modes, tuple(parameters.get(MODE_PARAMETER, self._modes))
        self._held = {n: held for n, held in self._held.items() if self.modes[n] == before[n]}

    def run(
        self,
        targets: Mapping[str, float | Sequence[float]],
        times: float | Sequence[float] = 0.0,
        start: float = 0.0,
    ) -> None:
        """Command channels to targets, interpolated linearly; the quantity is that of their mode.

        Args:
            targets: by channel, one value for each of `times`: air mass above rest [kg], mass flow
                [kg/s], gauge pressure [Pa] or volume above rest [m3].
            times: times of the targets after the start [s]; 0 for a step.
            start: time on the driver's clock [s]; 0: now.

        Raises:
            PneumaticboxError: an earlier message was refused, or the box has vented.
            ValueError: unknown channel, or the numbers of values and times differ.
        """
        columns = np.column_stack([np.atleast_1d(values) for values in targets.values()])
        moments = np.atleast_1d(times)
        if len(moments) != len(columns):
            raise ValueError(f"times must have {len(columns)} entries, got {len(moments)}")
        names = list(targets)
        rows = zip(moments.tolist(), columns.tolist(), strict=True)
        points = [self._point(names, moment, row) for moment, row in rows]
        self._send(BOX_COMMAND, names, points, start)
        due = max(start, self.now) + float(moments[-1])
        self._held |= {name: (value, due) for name, value in zip(names, columns[-1], strict=True)}

    def keep_alive(self) -> None:
        """Repeat the reached targets of `run`, once in `REPEAT_PERIOD` of the box's time.

        Without a command the driver vents after its `command_timeout`. `monitor` calls this method;
        programs that wait in another way must call it regularly.
        """
        now = self.now
        due = {name: value for name, (value, time) in self._held.items() if time <= now}
        if due and not 0 <= now - self._repeated < REPEAT_PERIOD:
            self._repeated = now
            self._send(
                BOX_COMMAND, list(due), [self._point(list(due), 0.0, list(due.values()))], 0.0
            )

    def schedule(
        self, events: Mapping[str, Sequence[tuple[float, int]]], start: float = 0.0
    ) -> None:
        """Schedule the valves of channels in mode time.

        Args:
            events: by channel, (time after the start [s], +1 inflate, -1 deflate or 0 closed).
            start: time on the driver's clock [s]; 0: now.

        Raises:
            PneumaticboxError, ValueError: as `run`.
        """
        for name, changes in events.items():
            points = [
                JointTrajectoryPoint(positions=[float(valve)], time_from_start=_duration(moment))
                for moment, valve in changes
            ]
            self._send(BOX_SCHEDULE, [name], points, start)

    def stop(self) -> str:
        """Close the valves and drop all targets, until `start`; returns the driver's answer."""
        self._let_go()
        return self._answer("enable", SetBool.Request(data=False))

    def start(self) -> str:
        """Accept commands again after `stop`."""
        return self._answer("enable", SetBool.Request(data=True))

    def vent(self) -> str:
        """Open all outlets, until `reset`."""
        self._let_go()
        self._complaints.vent_wanted = True
        return self._trigger("vent")

    def reset(self) -> str:
        """End a vent."""
        self._let_go()
        done = self._trigger("reset")
        self.diagnostics.pop("safety", None)
        self._complaints.vent_wanted, self._complaint = False, ""
        return done

    def tare(self) -> str:
        """Set the air masses from the pressures; nothing may touch the hand."""
        return self._trigger("tare")

    def calibrate(self) -> str:
        """Begin a calibration; `diagnostics["calibration"]` has its progress."""
        return self._trigger("calibrate")

    def calibrate_next(self) -> str:
        """Continue the calibration after the supply pressure was changed."""
        return self._trigger("calibrate_next")

    # internal

    def _let_go(self) -> None:
        """Stop to repeat targets; refusals of a target just repeated are ignored."""
        self._held.clear()
        self._complaints.forget_refusals()

    def _on_state(self, message: JointState) -> None:
        names = message.name
        fields = message.position, message.velocity, message.effort
        if not names or any(len(values) != len(names) for values in fields):
            got = ", ".join(str(len(values)) for values in fields)
            self._complaint = (
                f"pneumaticbox/state: expected a position, velocity and effort for each channel, "
                f"got {len(names)} names and {got} values"
            )
            return
        self._state = BoxState(
            seconds(message.header.stamp),
            dict(zip(names, message.position, strict=True)),
            dict(zip(names, message.velocity, strict=True)),
            dict(zip(names, message.effort, strict=True)),
        )
        self._states.append(self._state)

    def _on_diagnostics(self, message: DiagnosticArray) -> None:
        own = [status for status in message.status if status.name.startswith(self._prefix)]
        for status in own:
            values = {pair.key: pair.value for pair in status.values}
            level = int.from_bytes(status.level, "little")
            name = status.name.removeprefix(self._prefix)
            self.diagnostics[name] = Diagnosis(level, status.message, values)
        if own:
            self._complaint = self._complaints.of(self.diagnostics) or self._complaint

    def _raise_complaint(self) -> None:
        complaint, self._complaint = self._complaint, ""
        if complaint:
            self._held.clear()  # a refused target is not repeated
            raise PneumaticboxError(complaint)

    def _spread(self, modes: str | Sequence[str] | Mapping[str, str]) -> tuple[str, ...]:
        """Modes of all channels, in order."""
        if isinstance(modes, Mapping):
            self._check_channels(modes)
            return tuple(modes.get(name, mode) for name, mode in self.modes.items())
        listed = (modes,) if isinstance(modes, str) else tuple(modes)
        return listed * len(self.channels) if len(listed) == 1 else listed

    def _check_channels(self, names: Mapping[str, Any] | Sequence[str]) -> None:
        unknown = [name for name in names if name not in self.channels]
        if unknown:
            raise ValueError(f"channels must be out of {list(self.channels)}, got {unknown}")

    def _point(
        self, names: Sequence[str], moment: float, values: Sequence[float]
    ) -> JointTrajectoryPoint:
        """A point with the fields that the channels' modes read."""
        self._check_channels(names)
        fields = {CONTROL_MODES[self.modes[name]].field for name in names}
        filled = dict.fromkeys(fields, values)
        return JointTrajectoryPoint(time_from_start=_duration(moment), **filled)

    def _send(
        self, topic: str, names: list[str], points: list[JointTrajectoryPoint], start: float
    ) -> None:
        self._link.drain()
        self._raise_complaint()
        self._check_channels(names)
        message = JointTrajectory(joint_names=names, points=points)
        message.header.stamp = stamp_of_seconds(start)
        self._out[topic].publish(message)

    def _trigger(self, name: str) -> str:
        return self._answer(name, Trigger.Request())

    def _answer(self, name: str, request: Any) -> str:
        answer = self._call(name, request)
        if not answer.success:
            raise PneumaticboxError(answer.message)
        return str(answer.message)

    def _parameters(self, *names: str) -> list[Any]:
        answer = self._call("get_parameters", GetParameters.Request(names=list(names)))
        return [parameter_value_to_python(value) for value in answer.values]


def _duration(length: float) -> Duration:
    stamp = stamp_of_seconds(length)
    return Duration(sec=stamp.sec, nanosec=stamp.nanosec)
