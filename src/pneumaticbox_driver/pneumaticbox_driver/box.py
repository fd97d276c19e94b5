"""The pneumatic box without ROS: sensor samples and commands in, valves out."""

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from pneumaticbox_driver.calibration import ChannelCalibration
from pneumaticbox_driver.commands import CommandRules, Setpoints, TrajectoryPoint
from pneumaticbox_driver.controllers import BoxView, make_controller
from pneumaticbox_driver.observer import MassObserver
from pneumaticbox_driver.pulse_timing import PulseTiming
from pneumaticbox_driver.safety import SILENCE_LIMIT, PressureGuard, VentLatch
from pneumaticbox_driver.settings import BoxSettings
from pneumaticbox_driver.zeroing import StillPressure
from softhand_model.gas import air_mass

Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]
Valves = NDArray[np.int8]
UNEXPLAINED_PRESSURE = 5e3  # in an emptied channel: it was held away from rest when zeroed [Pa]
LONGEST_START = 1.0  # after which the box no longer waits for pressures to stand still [s]


class PneumaticBox:
    """Answers each sensor sample with the valves to command. Times in [s], arrays (n,), SI.

    It starts by averaging the sensors until they stand still, valves closed. A channel within
    the zero band is taken as being at ambient pressure: its sensor's offset and its mass are
    zeroed. Otherwise its mass is that of its rest volume at the measured pressure.

    A channel emptied while its actuator is held away from rest is zeroed too early: it then holds
    more air than at rest, and shows it by its pressure once the actuator is free. It is emptied
    again.

    Args:
        settings: of the box.
        calibrations: coefficients of the channels, one each.

    Raises:
        ValueError: another number of calibrations than channels.
    """

    def __init__(self, settings: BoxSettings, calibrations: Sequence[ChannelCalibration]) -> None:
        n = len(settings.channels)
        if len(calibrations) != n:
            raise ValueError(f"calibrations must be {n}, one a channel, got {len(calibrations)}")
        self.settings = settings
        self.rules = CommandRules(settings.channels, settings.control_modes)
        self.latch = VentLatch()
        self.guard = PressureGuard(np.array(settings.pressure_limits))
        self.observer = MassObserver(calibrations, settings.ambient)
        self.setpoints = Setpoints(n)
        self.enabled = settings.start_enabled
        self.offsets: Floats = np.zeros(n)  # of the channel sensors [Pa]
        self.pressures: Floats = np.full(n, settings.ambient)  # absolute, offsets taken off [Pa]
        self.supply = settings.ambient  # absolute [Pa]
        self.notes: list[str] = []  # warnings for the user, oldest first
        self._still = StillPressure(n)
        self._timing = PulseTiming(n, settings.shortest_pulse, settings.shortest_pause)
        modes = settings.control_modes
        self._controllers = {mode: make_controller(mode) for mode in modes}
        self._masks = {mode: np.array([m == mode for m in modes]) for mode in self._controllers}
        self._closed: Valves = np.zeros(n, dtype=np.int8)
        self._venting: Valves = np.full(n, -1, dtype=np.int8)
        self._restart()

    def _restart(self) -> None:
        """Begin anew: no setpoints, valves closed, sensors to be averaged first."""
        self.time = math.nan
        self.ready = False
        self.sensors_sound = False
        self.empty: Flags = np.zeros(len(self._closed), dtype=bool)
        self.setpoints.hold()
        self._timing.restart()
        self._still.restart()
        self._waited = 0.0
        self._last_command = math.nan
        self.observer.switch(self._closed, self.pressures, self.supply)

    @property
    def gauge(self) -> Floats:
        """Gauge pressures of the channels (n,) [Pa]."""
        return self.pressures - self.settings.ambient

    @property
    def valves(self) -> Valves:
        """The valves commanded last (n,): +1 inflate, -1 deflate, 0 closed."""
        return self._timing.valves

    # what comes in

    def on_sample(self, time: float, pressures_abs: Floats) -> Valves:
        """Take a sensor sample and answer it.

        Args:
            time: stamp of the sample [s]; an unchanged one repeats the last answer, an earlier
                one means that the clock was set back: the box begins anew.
            pressures_abs: absolute pressures of the channels, then of the supply (n + 1,) [Pa].

        Returns:
            Valves to command from now on (n,).
        """
        dt = time - self.time
        if dt < 0:
            self.notes.append("the clock was set back: setpoints dropped, air masses tared anew")
            self._restart()
        if not math.isfinite(pressures_abs.sum()):
            return self._sensor_fault(time, pressures_abs)
        if dt == 0:
            return self.valves
        if dt > SILENCE_LIMIT:
            self.latch.set(f"no sensor sample for {SILENCE_LIMIT * 1e3:.0f} ms")
        self._sense(time, dt if dt > 0 else 0.0, pressures_abs)
        return self._switch(self._answer(dt if dt > 0 else 0.0))

    def command(
        self, names: Sequence[str], points: Sequence[TrajectoryPoint], stamp: float, now: float
    ) -> None:
        """Follow a command from its `stamp`, or from `now` [s] when the stamp is 0.

        Raises:
            ValueError: the command cannot be used as it is, or the box takes none in its state;
                nothing has changed then.
        """
        trajectory = self.rules.check(names, points, stamp)
        if self.latch:
            raise ValueError(f"vented until reset ({self.latch.reasons[0]}): no command is taken")
        if not self.enabled:
            raise ValueError("disabled: no command is taken before pneumaticbox/enable")
        self.setpoints.take(trajectory, now)
        self.guard.unblock(trajectory.channels)
        self._last_command = now

    def _sense(self, time: float, dt: float, pressures_abs: Floats) -> None:
        self.sensors_sound = True
        self.time = time
        self.pressures = pressures_abs[:-1] - self.offsets
        self.supply = float(pressures_abs[-1])
        self.observer.advance(dt, self.pressures, self.supply)
        self._waited += dt
        self.empty &= self.gauge < UNEXPLAINED_PRESSURE
        if self._still.add(dt, self.pressures):
            self._zero_at_rest()

    def _sensor_fault(self, time: float, pressures_abs: Floats) -> Valves:
        bad = int(np.argmin(np.isfinite(pressures_abs)))
        name = (*self.settings.channels, "supply")[bad]
        self.latch.set(f"sensor {name}: not a number")
        self.sensors_sound = False
        self.time = time
        return self._switch(self._venting)

    # what it answers

    def _answer(self, dt: float) -> Valves:
        setpoints = self.setpoints.at(self.time)
        self._check_command_timeout()
        gauge = self.gauge
        burst = self.guard.burst(gauge)
        if burst is not None:
            name = self.settings.channels[burst]
            self.latch.set(f"channel {name}: pressure far above its limit")
        if self.latch:
            return self._venting
        idle = not (self.enabled and self.ready)
        wanted = self._closed if idle else self._controlled(setpoints, dt)
        # the limits come last: they do not wait for a pulse to end
        return self.guard.apply(gauge, setpoints, self._timing.follow(self.time, wanted))

    def _controlled(self, setpoints: Floats, dt: float) -> Valves:
        view = BoxView(
            dt=dt,
            shortest_pulse=self.settings.shortest_pulse,
            pressures=self.pressures,
            supply=self.supply,
            setpoints=setpoints,
            direction=self.valves,
            empty=self.empty,
            observer=self.observer,
        )
        wanted = self._closed
        for mode, controller in self._controllers.items():
            wanted = np.where(self._masks[mode], controller.update(view), wanted)
        return wanted

    def _switch(self, valves: Valves) -> Valves:
        changed = valves != self.valves
        if changed.any():
            self._timing.switch(self.time, valves)
            self.observer.switch(valves, self.pressures, self.supply)
            self.empty &= valves <= 0
            self._still.restart(changed)
        return self.valves

    def _check_command_timeout(self) -> None:
        limit = self.settings.command_timeout
        silence = self.time - max(self._last_command, self.setpoints.last_time)
        if limit > 0 and silence > limit:
            self.latch.set(f"no command for {limit} s")

    # known masses

    def _zero_at_rest(self) -> None:
        """Zero what stands still at ambient pressure: at the start, and with outlets open."""
        if not self.ready:
            if self._still.still.all() or self._waited > LONGEST_START:
                self._tare_all()
                self.ready = True
            return
        at_ambient = self._still.still & self._within_zero_band()
        for channel in np.flatnonzero((self.valves < 0) & at_ambient & ~self.empty).tolist():
            self._zero(channel)

    def _within_zero_band(self) -> Flags:
        reading = self._still.mean + self.offsets - self.settings.ambient
        return np.abs(reading) < self.settings.zero_band

    def _zero(self, channel: int) -> None:
        """Take the channel's averaged pressure as ambient, its mass as that at rest."""
        error = float(self._still.mean[channel]) - self.settings.ambient
        self.offsets[channel] += error
        self.pressures[channel] -= error
        self.observer.set_mass(channel, 0.0)
        self.empty[channel] = True

    def _tare_all(self) -> list[str]:
        """Set all masses from the averaged pressures; returns the channels not at ambient."""
        at_ambient = self._within_zero_band()
        under_pressure = []
        for channel, name in enumerate(self.settings.channels):
            if at_ambient[channel]:
                self._zero(channel)
                continue
            gauge = float(self._still.mean[channel]) - self.settings.ambient
            volume = self.settings.rest_volumes[channel]
            mass = float(air_mass(gauge, volume, self.settings.temperature))
            self.observer.set_mass(channel, mass)
            under_pressure.append(name)
        self._still.restart()
        if under_pressure:
            self.notes.append(f"tared under pressure by the rest volume: {under_pressure}")
        return under_pressure

    # services

    def tare(self) -> str:
        """Set the air masses from the pressures: the hand stands in its rest posture.

        Returns:
            A sentence on what was done.

        Raises:
            ValueError: valves are open, or the pressures do not stand still yet.
        """
        if self.valves.any():
            raise ValueError("valves are open: tare when the channels are at rest")
        if not (self.ready and self._still.still.all()):
            raise ValueError("pressures do not stand still yet: tare again in a moment")
        under_pressure = self._tare_all()
        self.setpoints.hold()
        zeroed = [name for name in self.settings.channels if name not in under_pressure]
        return f"zeroed at ambient: {zeroed}; by rest volume: {under_pressure}"

    def vent(self, reason: str = "vent was requested") -> None:
        """Open every outlet with the next sample and stay so until `reset`."""
        self.latch.set(reason)
        self.setpoints.hold()

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
        self.setpoints.hold()
        self._last_command = math.nan
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
        if on:
            return "commands are taken"
        return "disabled: " + ("outlets stay open" if self.latch else "valves are closed")
