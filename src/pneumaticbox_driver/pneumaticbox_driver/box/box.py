"""The pneumatic box without ROS: sensor samples and commands in, valves out."""

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from pneumaticbox_driver.box.commands import Trajectory, TrajectoryPoint
from pneumaticbox_driver.box.state import BoxState
from pneumaticbox_driver.calibration.run import CalibrationRun
from pneumaticbox_driver.faults.fault_watch import FaultView
from pneumaticbox_driver.safety import SILENCE_LIMIT

Floats = NDArray[np.float64]
Valves = NDArray[np.int8]
FRESH_CLOCK = 1.0  # set back to less, the clock is that of a simulation that was reset [s]


class PneumaticBox(BoxState):
    """Answers each sensor sample with the valves to command. Times in [s], arrays (n,), SI.

    It starts by averaging the sensors until they stand still, valves closed. A channel within
    the zero band is taken as being at ambient pressure: its sensor's offset and its mass are
    zeroed. Otherwise its mass is that of its free volume at the measured pressure.

    A channel emptied while its actuator is held away from rest keeps the estimate of what is left
    in it; by its pressure it shows when the actuator is free, and is emptied again.

    Args:
        settings: of the box.
        calibrations: coefficients of the channels, one each.
        volumes: model of the channels' volumes; None for the one that the settings name.

    Raises:
        ValueError: another number of calibrations than channels, or a hand that does not exist.
    """

    # what comes in

    def on_sample(self, time: float, pressures_abs: Floats) -> Valves:
        """Take a sensor sample and answer it.

        Args:
            time: stamp of the sample [s]; an unchanged one repeats the last answer, an earlier
                one means that the clock was set back: the box begins anew, latched unless it is
                the first second of a simulation.
            pressures_abs: absolute pressures of the channels, then of the supply (n + 1,) [Pa].

        Returns:
            Valves to command from now on (n,).
        """
        dt = time - self.time
        if dt < 0:
            self._clock_set_back(time, -dt)
        if not math.isfinite(pressures_abs.sum()):
            return self._sensor_fault(time, pressures_abs)
        if dt == 0:
            return self.valves
        if dt > SILENCE_LIMIT:
            self.latch.set(f"no sensor sample for {SILENCE_LIMIT * 1e3:.0f} ms")
        self._sense(time, dt if dt > 0 else 0.0, pressures_abs)
        self._look_for_faults(dt if dt > 0 else 0.0, pressures_abs)
        return self._switch(self._answer(dt if dt > 0 else 0.0))

    def command(
        self, names: Sequence[str], points: Sequence[TrajectoryPoint], stamp: float, now: float
    ) -> None:
        """Follow a command from its `stamp`, or from `now` [s] when the stamp is 0.

        Raises:
            ValueError: the command cannot be used as it is, or the box takes none in its state;
                nothing has changed then.
        """
        self._take(self._intake.rules.check(names, points, stamp), now)

    def schedule_valves(
        self, names: Sequence[str], points: Sequence[TrajectoryPoint], stamp: float, now: float
    ) -> None:
        """Follow a schedule of valves on channels in mode time from its `stamp`, or `now` [s].

        Positions are +1 inflate, -1 deflate, 0 closed; an event acts at the sample nearest to it.

        Raises:
            ValueError: as `command` does.
        """
        self._take(self._intake.rules.check_schedule(names, points, stamp), now)

    def _take(self, trajectory: Trajectory, now: float) -> None:
        self._refuse_unless_active("no command is taken")
        self._calibrating.refuse_under_way()
        self._intake.take(trajectory, now)
        self.guard.unblock(trajectory.channels)

    def _refuse_unless_active(self, what: str) -> None:
        """Raise ValueError, saying `what` is not done, while vented or disabled."""
        if self.latch:
            raise ValueError(f"vented until reset ({self.latch.reasons[0]}): {what}")
        if not self.enabled:
            raise ValueError(f"disabled: {what} before pneumaticbox/enable")

    def _clock_set_back(self, time: float, step: float) -> None:
        if time >= FRESH_CLOCK:
            self.latch.set(f"the clock was set back by {step:.3f} s")
        self.notes.append("the clock was set back: setpoints dropped, air masses tared anew")
        self._restart()

    def _sense(self, time: float, dt: float, pressures_abs: Floats) -> None:
        self.sensors_sound = True
        self.time = time
        self.pressures = pressures_abs[:-1] - self.offsets
        self.supply = float(pressures_abs[-1])
        self._readings = pressures_abs
        self.observer.advance(dt, self.pressures, self.supply)
        if self.leak_model:
            self.observer.lose(dt * self._leak * np.maximum(self.gauge, 0.0))
        if not self._calibrating.under_way:
            self._known.look(dt, self.pressures, self.valves)

    def _look_for_faults(self, dt: float, readings: Floats) -> None:
        if not self._faults.due(dt, readings):
            return
        view = FaultView(
            gauge=self.gauge,
            supply=self.supply - self.settings.ambient,
            valves=self.valves,
            flow=self.observer.flow,
            mass=self.observer.mass,
            mass_known=~(self.empty | self._calibrating.under_way),
            ready=self.ready,
        )
        for reason in self._faults.look(view):
            if reason not in self.latch.reasons:
                self._known.doubt()
            self.latch.set(reason)

    def stuck_outlets(self) -> list[str]:
        """Say which outlets do not let the air out although they are commanded open."""
        return self._faults.stuck_outlets()

    def _sensor_fault(self, time: float, pressures_abs: Floats) -> Valves:
        bad = int(np.argmin(np.isfinite(pressures_abs)))
        name = (*self.settings.channels, "supply")[bad]
        self.latch.set(f"sensor {name}: not a number")
        self.sensors_sound = False
        self.time = time
        self._known.doubt()
        self._look_for_faults(0.0, pressures_abs)
        return self._switch(self._venting)

    # what it answers

    def _answer(self, dt: float) -> Valves:
        setpoints = self.setpoints.at(self.time, dt)
        if self._intake.silent(self.time):
            self.latch.set(f"no command for {self.settings.command_timeout} s")
        gauge = self.gauge
        burst = self.guard.burst(gauge)
        if burst is not None:
            name = self.settings.channels[burst]
            self.latch.set(f"channel {name}: pressure far above its limit")
        if self.latch:
            self._calibrating.abort(self.latch.reasons[0])
            return self._venting
        if self._calibrating.under_way:
            wanted = self._calibrated()
        else:
            idle = not (self.enabled and self.ready)
            wanted = self._closed if idle else self._controlled(setpoints, dt)
            wanted = self._timing.follow(self.time, wanted)
        # the limits come last: they do not wait for a pulse to end
        return self.guard.apply(gauge, setpoints, wanted)

    def _calibrated(self) -> Valves:
        wanted = self._calibrating.answer(self.time, self._readings, self.guard)
        if not self._calibrating.under_way:
            self._known.restart()  # what came in meanwhile was not followed
        return wanted

    def _controlled(self, setpoints: Floats, dt: float) -> Valves:
        view = self._view
        view.dt, view.supply = dt, self.supply
        view.pressures, view.setpoints = self.pressures, setpoints
        view.direction, view.empty = self.valves, self.empty
        return self._bank.update(view)

    def _switch(self, valves: Valves) -> Valves:
        changed = valves != self.valves
        if changed.any():
            self._timing.switch(self.time, valves)
            self.observer.switch(valves, self.pressures, self.supply)
            self._known.switched(changed, valves)
            self.openings += changed & (valves != 0)
        return self.valves

    # modes

    def set_modes(self, modes: Sequence[str]) -> str:
        """Switch control modes without a jump: what is now becomes the setpoint in its new unit.

        The new setpoint of a channel that switches is its estimated mass, its measured pressure or
        its estimated volume, a mass flow of 0, or closed valves. There is none where the channel
        is empty or has no setpoint to hold: disabled, vented, or before the sensors are averaged.

        Args:
            modes: one per channel (n,).

        Returns:
            A sentence on what was done.

        Raises:
            ValueError: another number of modes, or one that cannot be used; nothing has changed.
        """
        self.settings.check_modes(modes)
        self._calibrating.refuse_under_way()
        values = np.array([self._present(i, mode) for i, mode in enumerate(modes)])
        self._bank.switch(modes)
        self.guard.unblock(self._intake.switch(modes, values))
        return f"control modes: {', '.join(modes)}"

    def _present(self, channel: int, mode: str) -> float:
        """What is now on a channel, as the setpoint of a mode."""
        if mode in ("mass_flow", "time"):
            return 0.0
        if self.latch or not (self.enabled and self.ready):
            return math.nan
        steady = self._known.steady(self.pressures)
        found = {
            "mass": self.observer.mass,
            "pressure": steady - self.settings.ambient,
            "volume": self._view.volume_at(steady) - self._view.rest_volumes,
        }
        value = float(found[mode][channel])
        # a setpoint of zero or below would open the outlet of a channel that is not known as empty
        return value if value > 0 else math.nan

    # services

    def tare(self) -> str:
        """Set the air masses from the pressures: nothing touches the hand.

        Returns:
            A sentence on what was done.

        Raises:
            ValueError: valves are open, or the pressures do not stand still yet.
        """
        self._calibrating.refuse_under_way()
        if self.valves.any():
            raise ValueError("valves are open: tare when the channels are at rest")
        if not (self.ready and self._known.still):
            raise ValueError("pressures do not stand still yet: tare again in a moment")
        under_pressure = self._known.tare(self.pressures)
        self.setpoints.hold()
        zeroed = [name for name in self.settings.channels if name not in under_pressure]
        return f"zeroed at ambient: {zeroed}; by free volume: {under_pressure}"

    def vent(self, reason: str = "vent was requested") -> None:
        """Open every outlet with the next sample and stay so until `reset`."""
        self.latch.set(reason)
        self._calibrating.abort(reason)
        self._intake.drop()

    def reset(self) -> str:
        """Leave the safe state: valves close, no setpoints, commands are taken if enabled.

        Returns:
            A sentence on what was done.

        Raises:
            ValueError: the last sensor sample was unusable, or there was none; still vented.
        """
        if not self.sensors_sound:
            raise ValueError("no usable sensor sample: still vented")
        self.latch.release()
        self.guard.restart()
        self._faults.restart()
        self._known.settle_doubts()
        self._intake.drop()
        taken = "commands are taken" if self.enabled else "disabled until pneumaticbox/enable"
        return f"valves are closed, {taken}"

    def enable(self, on: bool) -> str:
        """Start or stop control; stopped, the valves are closed and setpoints dropped.

        Returns:
            A sentence on what was done.

        Raises:
            ValueError: started while vented; nothing has changed then.
        """
        if on and self.latch:
            reason = self.latch.reasons[0]
            raise ValueError(f"vented ({reason}): pneumaticbox/reset must come first")
        self.enabled = on
        self.setpoints.hold()
        if not on:
            self._calibrating.abort("the box was disabled")
        if on:
            return "commands are taken"
        return "disabled: " + ("outlets stay open" if self.latch else "valves are closed")

    def start_calibration(self, run: CalibrationRun) -> str:
        """Let a calibration answer the samples, with a fixed volume on every channel.

        Limits and latch still apply; commands are refused until it has ended. Then the sensors are
        averaged anew; what it found is the caller's, for `set_calibrations`.

        Returns:
            A sentence on what was done.

        Raises:
            ValueError: vented, disabled, one is under way, or the run is for other channels.
        """
        self._refuse_unless_active("no calibration is begun")
        done = self._calibrating.start(run)
        self.setpoints.hold()
        return done

    def calibrate_next(self) -> str:
        """Let the calibration go on at another supply pressure.

        Returns:
            A sentence on what is done now.

        Raises:
            ValueError: it does not wait, or the supply pressure is one of before.
        """
        return self._calibrating.next()
