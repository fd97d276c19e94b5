"""The pneumatic box without ROS: sensor samples and commands in, valves out.

`commands` checks commands and turns them into setpoints over time. For each sample the `observer`
estimates the air masses, `zeroing` sets them where they are known, `faults` looks for broken parts,
`control` computes the valves from the setpoints, and `guard` and `latch` may overrule it.
"""

import math
import traceback
from collections.abc import Sequence

import numpy as np

from pneumaticbox_driver.arrays import Counts, Flags, Floats, Valves, same
from pneumaticbox_driver.box.commands import CommandIntake, Trajectory, TrajectoryPoint
from pneumaticbox_driver.box.estimates import EstimateCheck
from pneumaticbox_driver.box.ranges import target_ranges
from pneumaticbox_driver.calibration.run import CalibrationRun, CalibrationSession
from pneumaticbox_driver.control.channels import PRESENT, ChannelControl, ControlError, PulseTiming
from pneumaticbox_driver.control.interface import BoxView
from pneumaticbox_driver.faults.fault_watch import FaultView, FaultWatch
from pneumaticbox_driver.modes import MODES
from pneumaticbox_driver.observer.coefficients import ChannelCalibration
from pneumaticbox_driver.observer.observer import MassObserver
from pneumaticbox_driver.observer.volume_model import VolumeModel, make_volume_model
from pneumaticbox_driver.observer.zeroing import Zeroing
from pneumaticbox_driver.safety import SAMPLE_SILENCE_LIMIT, PressureGuard, VentLatch, one_line
from pneumaticbox_driver.settings import BoxSettings
from softhand_model.gas import GAS_CONSTANT

MODES_OF_AIR = ("mass", "mass_flow", "volume")  # which require a known air mass
LEAST_ABS, MOST_ABS = 0.0, 10e6  # range of possible absolute pressures [Pa]
FRESH_CLOCK = 1.0  # a clock set back to an earlier time is that of a simulation that was reset [s]


class PneumaticBox:
    """Computes the valves for each sensor sample. Times in [s], arrays (n,), SI units.

    At the start it averages the sensors, with closed valves, until the pressures are constant. A
    channel within the zero band is assumed to be at ambient pressure: its mass and the offset of
    its sensor are set to zero. For other channels the mass is that of the free volume at the
    measured pressure.

    A channel that was emptied while its actuator was held away from rest keeps the estimate of the
    air left in it. When the actuator is released, the pressure changes and the channel is emptied
    again.

    Any error during a sample opens the outlets until `reset`.

    Attributes:
        valves: the last commanded valves (n,).
        openings: number of openings of each valve (n,).
        notes: warnings for the user, the oldest first.

    Args:
        settings: settings of the box.
        calibrations: coefficients of the channels, one each.
        volumes: model of the channels' volumes; None for that of the settings.

    Raises:
        ValueError: the number of calibrations is not that of the channels, or the hand does not
            exist.
    """

    def __init__(
        self,
        settings: BoxSettings,
        calibrations: Sequence[ChannelCalibration],
        volumes: VolumeModel | None = None,
    ) -> None:
        n = len(settings.channels)
        if len(calibrations) != n:
            raise ValueError(f"calibrations must be {n}, one per channel, got {len(calibrations)}")
        model = volumes or make_volume_model(
            settings.volume_model, settings.hand, settings.rest_volumes
        )
        self.settings = settings
        self.enabled = settings.start_enabled
        self.notes: list[str] = []
        self.pressures_abs: Floats = np.full(
            n, settings.ambient
        )  # absolute, without the offsets [Pa]
        self.supply_abs = settings.ambient  # absolute [Pa]
        self.valves: Valves = np.zeros(n, dtype=np.int8)
        self.openings: Counts = np.zeros(n, dtype=np.int64)
        ranges = target_ranges(settings, model)
        self.commands = CommandIntake(settings, ranges)
        greatest = np.array(settings.rest_volumes) + ranges["volume"][1]
        self.estimates = EstimateCheck(settings, greatest)
        self.observer = MassObserver(calibrations, settings.ambient)
        self.zeroing = Zeroing(settings, self.observer, model, self.notes)
        self.faults = FaultWatch(settings)
        self.calibration = CalibrationSession(settings.channels)
        self.control = ChannelControl(settings.control_modes)
        self.guard = PressureGuard(np.array(settings.pressure_limits))
        self.latch = VentLatch()
        self._timing = PulseTiming(n, settings.shortest_pulse, settings.shortest_pause)
        self._view = BoxView(
            observer=self.observer,
            volume_model=model,
            rest_volumes=np.array(settings.rest_volumes),
            limits=self.guard.limits,
            ambient=settings.ambient,
            gas=GAS_CONSTANT * settings.temperature,
            shortest_pulse=settings.shortest_pulse,
        )
        self._closed: Valves = np.zeros(n, dtype=np.int8)
        self._venting: Valves = np.full(n, -1, dtype=np.int8)
        self.restart()

    def restart(self) -> None:
        """Return to the state at the start: no setpoints, closed valves, sensors to be averaged."""
        self.time = math.nan
        self.sensors_sound = False
        self.valves = self._closed
        self.commands.drop()
        self._timing.restart()
        self.zeroing.restart()
        self.faults.begin()
        self.observer.switch(self._closed, self.pressures_abs, self.supply_abs)

    @property
    def pressures(self) -> Floats:
        """Gauge pressures of the channels (n,) [Pa]."""
        return self.pressures_abs - self.settings.ambient

    @property
    def volume(self) -> Floats:
        """Volumes above those at rest (n,) [m3], `V = m R_s T/p_abs` of the estimated mass."""
        return self._view.volume_at(self.pressures_abs) - self._view.rest_volumes

    # samples and commands

    def on_sample(self, time: float, pressures_abs: Floats) -> Valves:
        """Compute the valves for a sensor sample.

        Args:
            time: stamp of the sample [s]. If it is that of the last sample, the last answer is
                repeated, unless the box has begun to vent meanwhile. If it is earlier, the clock
                was set back: the box starts anew, and vents until `reset` unless a simulation is in
                its first second.
            pressures_abs: absolute pressures of the channels, then of the supply (n + 1,) [Pa].

        Returns:
            Valves to command from now on (n,).
        """
        dt = time - self.time
        if dt < 0:
            self._clock_set_back(time, -dt)
        try:
            return self._switch(self._step(time, dt, pressures_abs))
        except Exception as error:  # noqa: BLE001 any error must open the outlets
            self._break_down(time, error)
            return self._switch(self._venting)

    def _step(self, time: float, dt: float, pressures_abs: Floats) -> Valves:
        sound = [LEAST_ABS < value < MOST_ABS for value in pressures_abs.tolist()]  # and no NaN
        if not all(sound):
            return self._sensor_fault(time, pressures_abs, sound.index(False))
        if dt == 0:
            return self._venting if self.latch else self.valves
        if dt > SAMPLE_SILENCE_LIMIT:
            self.latch.set(f"no sensor sample for {SAMPLE_SILENCE_LIMIT * 1e3:.0f} ms")
        dt = max(0.0, dt)  # NaN at the first sample
        self._sense(time, dt, pressures_abs)
        self._look_for_faults(dt, pressures_abs)
        return self._answer(dt, pressures_abs)

    def command(
        self, names: Sequence[str], points: Sequence[TrajectoryPoint], stamp: float, now: float
    ) -> None:
        """Execute a command from its `stamp` on, or from `now` [s] on if the stamp is 0.

        Raises:
            ValueError: the command is not valid, or the box accepts none in its present state;
                nothing has changed then.
        """
        self._take(self.commands.rules.check(names, points, stamp), now)

    def schedule_valves(
        self, names: Sequence[str], points: Sequence[TrajectoryPoint], stamp: float, now: float
    ) -> None:
        """Execute a valve schedule of channels in mode `time`, from its `stamp` on, or from `now`
        [s] on if the stamp is 0.

        Positions are +1 inflate, -1 deflate, 0 closed; an event acts at the sample nearest to it.

        Raises:
            ValueError: as `command` does.
        """
        self._take(self.commands.rules.check_schedule(names, points, stamp), now)

    def _take(self, trajectory: Trajectory, now: float) -> None:
        self._refuse_unless_active("no command is taken")
        self.calibration.refuse_under_way()
        self._refuse_unknown(trajectory.channels)
        self.commands.take(trajectory, now)

    def _refuse_unknown(self, channels: Sequence[int]) -> None:
        """Raise ValueError if a channel in a mode of `MODES_OF_AIR` has an unknown air mass."""
        names = {self.settings.channels[channel] for channel in channels}
        unknown = [name for name in self._unknown() if name in names]
        if unknown and self.zeroing.ready:
            raise ValueError(
                f"air mass of channels {unknown} is not known since the vent: call "
                "pneumaticbox/tare with nothing touching the hand, or vent until they are empty"
            )

    def _unknown(self) -> list[str]:
        """Channels in a mode of `MODES_OF_AIR` whose estimate a fault has invalidated."""
        modes = zip(self.settings.channels, self.control.modes, self.zeroing.doubted, strict=True)
        return [name for name, mode, doubted in modes if doubted and mode in MODES_OF_AIR]

    def _refuse_unless_active(self, what: str) -> None:
        """Raise ValueError while vented or disabled; `what` names the refused action."""
        if self.latch:
            raise ValueError(f"vented until reset ({self.latch.reasons[0]}): {what}")
        if not self.enabled:
            raise ValueError(f"disabled: {what} before pneumaticbox/enable")

    def _clock_set_back(self, time: float, step: float) -> None:
        if time >= FRESH_CLOCK:
            self.latch.set(f"the clock was set back by {step:.3f} s")
        self.notes.append("the clock was set back: setpoints dropped, air masses tared anew")
        self.calibration.abort("the clock was set back")
        self.restart()

    def _sense(self, time: float, dt: float, pressures_abs: Floats) -> None:
        self.sensors_sound = True
        self.time = time
        self.pressures_abs = pressures_abs[:-1] - self.zeroing.offsets
        self.supply_abs = float(pressures_abs[-1])
        self.observer.advance(dt, self.pressures_abs, self.supply_abs)
        if not self.calibration.under_way:
            self.zeroing.look(dt, self.pressures_abs, self.valves)

    def _look_for_faults(self, dt: float, readings: Floats) -> None:
        if not self.faults.due(dt, readings):
            return
        view = FaultView(
            pressures=self.pressures,
            supply=self.supply_abs - self.settings.ambient,
            valves=self.valves,
            flow=self.observer.flow,
            mass=self.observer.mass,
            mass_known=~(self.zeroing.empty | self.zeroing.doubted | self.calibration.under_way),
            ready=self.zeroing.ready,
        )
        for reason in self.faults.look(view):
            if reason not in self.latch.reasons:
                self.zeroing.doubt()
            self.latch.set(reason)
        known = view.mass_known & view.ready & self.sensors_sound
        self.notes += self.estimates.look(
            self.time, view.mass, self.zeroing.drift_bound, self.pressures_abs, known
        )

    def _sensor_fault(self, time: float, pressures_abs: Floats, bad: int) -> Valves:
        name, value = (*self.settings.channels, "supply")[bad], pressures_abs[bad]
        what = "not a number" if np.isnan(value) else f"no absolute pressure is {value:.3g} Pa"
        self.latch.set(f"sensor {name}: {what}")
        self.sensors_sound = False
        self.time = time
        self.zeroing.doubt()
        self._look_for_faults(0.0, pressures_abs)
        return self._venting

    def _break_down(self, time: float, error: BaseException) -> None:
        """Vent after an unexpected error, and note its traceback the first time."""
        where = "control step"
        if isinstance(error, ControlError):
            names = ", ".join(self.settings.channels[channel] for channel in error.channels)
            where, error = f"channels {names}, mode {error.mode}", error.__cause__ or error
        reason = f"{where}: {one_line(error)}"
        if reason not in self.latch.reasons:
            lines = traceback.format_tb(error.__traceback__)
            self.notes.append(f"the control step failed: {reason}\n{''.join(lines)}")
        self.time = time
        self.zeroing.doubt()
        self.calibration.abort(reason)
        self.vent(reason)

    # valves

    def _answer(self, dt: float, readings: Floats) -> Valves:
        setpoints = self.commands.setpoints.at(self.time, dt)
        if begun := self.commands.begun(self.time):
            self.guard.unblock(begun)
        if self.commands.silent(self.time) and self._holds_air(setpoints):
            self.latch.set(f"no command for {self.settings.command_timeout} s")
        pressures = self.pressures
        burst = self.guard.burst(pressures)
        if burst is not None:
            name = self.settings.channels[burst]
            self.latch.set(f"channel {name}: pressure far above its limit")
        if self.latch:
            self.calibration.abort(self.latch.reasons[0])
            return self._venting
        if self.calibration.under_way:
            wanted = self._calibrated(readings)
        else:
            idle = not (self.enabled and self.zeroing.ready)
            wanted = self._closed if idle else self._controlled(setpoints, dt)
            wanted = self._timing.follow(self.time, self.valves, wanted)
        # the limits come last, so that they do not wait for the end of a pulse
        return self.guard.apply(pressures, setpoints, wanted)

    def _holds_air(self, setpoints: Floats) -> bool:
        """Whether a channel contains air and its setpoint (n,) does not empty it."""
        let_out = np.array([MODES[mode].absolute for mode in self.control.modes]) & (setpoints <= 0)
        return not (self.zeroing.empty | let_out).all()

    def _calibrated(self, readings: Floats) -> Valves:
        wanted = self.calibration.answer(self.time, readings, self.guard)
        if not self.calibration.under_way:
            self.zeroing.restart()  # the air masses were not tracked during the calibration
        return wanted

    def _controlled(self, setpoints: Floats, dt: float) -> Valves:
        view = self._view
        view.dt, view.supply_abs = dt, self.supply_abs
        view.pressures_abs, view.setpoints = self.pressures_abs, setpoints
        view.direction, view.empty = self.valves, self.zeroing.empty
        return self.control.update(view)

    def _switch(self, valves: Valves) -> Valves:
        if not same(valves, self.valves):
            changed: Flags = valves != self.valves
            self.valves = valves.copy()
            self._timing.note(self.time, changed)
            self.observer.switch(valves, self.pressures_abs, self.supply_abs)
            self.zeroing.switched(changed, valves)
            self.openings += changed & (valves != 0)
        return self.valves

    # requests of the user

    def set_modes(self, modes: Sequence[str]) -> str:
        """Switch control modes without a jump: the present state becomes the setpoint.

        The new setpoint of a channel that switches is its estimated mass, its measured pressure or
        its estimated volume, a mass flow of 0, or closed valves. A channel gets no setpoint if it
        is empty, or while the box is disabled, vented or still averages its sensors.

        Args:
            modes: one per channel (n,).

        Returns:
            A sentence on what was done.

        Raises:
            ValueError: wrong number of modes, or a mode that cannot be used; nothing has changed.
        """
        self.settings.check_modes(modes)
        self.calibration.refuse_under_way()
        values = [self._present(channel, mode) for channel, mode in enumerate(modes)]
        self.control.switch(modes)
        self.guard.unblock(self.commands.switch(modes, values))
        return f"control modes: {', '.join(modes)}"

    def hold(self) -> str:
        """Drop all commands, so that each channel keeps its air. Returns a sentence that says
        so.
        """
        self.calibration.abort("hold was requested")
        modes = enumerate(self.control.modes)
        self.commands.hold([self._present(channel, mode) for channel, mode in modes], self.time)
        return "the channels keep their content"

    def _present(self, channel: int, mode: str) -> float:
        """The present state of a channel as a setpoint of a mode."""
        idle = MODES[mode].idle
        if mode not in PRESENT or self.latch or not (self.enabled and self.zeroing.ready):
            return idle
        steady_abs = self.zeroing.steady(self.pressures_abs)
        value = float(PRESENT[mode](self._view, steady_abs)[channel])
        # a setpoint of zero or below would open the outlet of a channel that may not be empty
        return value if value > 0 else idle

    def tare(self) -> str:
        """Set the air masses from the pressures, assuming that nothing touches the hand.

        Returns:
            A sentence on what was done.

        Raises:
            ValueError: valves are open, or the pressures are not constant yet.
        """
        self.calibration.refuse_under_way()
        if self.valves.any():
            raise ValueError("valves are open: tare when the channels are at rest")
        if not (self.zeroing.ready and self.zeroing.still):
            raise ValueError("pressures are not constant yet: tare again in a moment")
        under_pressure = self.zeroing.tare(self.pressures_abs)
        self.commands.setpoints.hold()
        zeroed = [name for name in self.settings.channels if name not in under_pressure]
        return f"zeroed at ambient: {zeroed}; by free volume: {under_pressure}"

    def vent(self, reason: str = "vent was requested") -> None:
        """Open every outlet with the next sample, until `reset`."""
        self.latch.set(reason)
        self.calibration.abort(reason)
        self.commands.drop()

    def reset(self) -> str:
        """End the vent: valves close, setpoints are dropped, commands are accepted if enabled.

        Returns:
            A sentence on what was done.

        Raises:
            ValueError: there was no usable sensor sample; the box stays vented.
        """
        if not self.sensors_sound:
            raise ValueError(
                "reset: expected a sensor sample with a number for every channel, got none; "
                "the box stays vented"
            )
        self.latch.release()
        self.control.restart()
        self.guard.restart()
        self.faults.restart()
        self.commands.drop()
        taken = "commands are taken" if self.enabled else "disabled until pneumaticbox/enable"
        unknown = self._unknown()
        tare = f"; pneumaticbox/tare first, air mass not known on {unknown}" if unknown else ""
        return f"valves are closed, {taken}{tare}"

    def enable(self, on: bool) -> str:
        """Switch control on or off; switching off closes the valves and drops setpoints.

        Returns:
            A sentence on what was done.

        Raises:
            ValueError: control cannot be switched on while the box vents; nothing has changed then.
        """
        if on and self.latch:
            reason = self.latch.reasons[0]
            raise ValueError(f"vented ({reason}): pneumaticbox/reset must come first")
        self.enabled = on
        self.commands.setpoints.hold()
        if on:
            return "commands are taken"
        self.calibration.abort("the box was disabled")
        return "disabled: " + ("outlets stay open" if self.latch else "valves are closed")

    def start_calibration(self, run: CalibrationRun) -> str:
        """Let a calibration command the valves, with a fixed volume on every channel.

        Limits and vent still apply; commands are refused until it has ended. Then the sensors are
        averaged again; the caller passes the result to `observer.set_calibrations`.

        Returns:
            A sentence on what was done.

        Raises:
            ValueError: the box is vented or disabled, another calibration is running, or the run is
                for other channels.
        """
        self._refuse_unless_active("no calibration is begun")
        done = self.calibration.start(run)
        self.commands.drop()
        return done
