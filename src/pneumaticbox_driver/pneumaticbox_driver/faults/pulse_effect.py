"""Holds the pulses that were commanded against what they did to the pressures."""

import math
from typing import Any

import numpy as np

from pneumaticbox_driver.arrays import Flags, Floats, Valves
from pneumaticbox_driver.settings import BoxSettings
from softhand_model.gas import GAS_CONSTANT
from softhand_model.numerics.compiled import compiled

SMOOTHING = 0.03  # low-pass of the pressures: 60 Pa of noise become 15 at 500 Hz [s]
# By how much the walls may give way. Mass is conserved, so a pulse of mass m raises the pressure
# by at least m R T over the volume plus p dV/dp. Half a litre is ten times what a finger's
# channel takes up that way, and it is the bottle that stands there during a calibration.
WIDEST_GROWTH = 0.5e-3  # [m3]
# A pulse shorter than the opening delay of the slowest valve may move nothing at all.
OPENING = 0.04  # [s]
# Before this nothing is expected of a pulse under way: slowest valve, low-pass, a sample.
LATENCY = 0.08  # [s]
SETTLING = 0.1  # after a pulse, for the closing delay, dead volume and low-pass [s]
SIGMAS = 4.0  # of noise that are not yet a motion
LEAST_NOISE = 61.0  # the step of a 12-bit converter for 250 kPa [Pa]
# What a low-passed pressure stays within when nothing moves, at most: 2.5 sigma of a difference
# with three times the noise of Table 4.1 at samples 10 ms apart.
UNMOVED = 240.0  # [Pa]
# Five times that: the flow may be overestimated fivefold, by a calibration of other chokes, in
# the widest volume and the verdict is still right.
EXPECTED = 1200.0  # [Pa]
# While a valve is open, a hand that opens or closes may keep the pressure where it is. It shows
# once the valve has closed. Before, four times the evidence: 30 mg, about all that a finger holds.
WHILE_OPEN = 4.0
# Below this drop the errors of the supply's sensor (2.5 % of 700 kPa) and of the channel's (1.4 %
# of 250 kPa) could make up half of it.
LEAST_DROP = 42e3  # from the supply into a channel [Pa]
# No error of class makes so little of ambient pressure: the sensor is at the end of its range.
RANGE_END = -3500.0  # gauge [Pa]


class PulseEffect:
    """Sums up the change of pressure that pulses must have brought, in the widest channel.

    `idle` (n,) marks channels whose pressure stood still under pulses that must have moved it,
    `unvented` (n,) those whose pressure does not fall with the outlet commanded open. Pressure
    that moves clears the first, pressure that falls the second: a push may hide a fault for as
    long as it lasts, but would have to undo a pulse to the noise, and stop with it, to feign one.

    Args:
        settings: of the box.
    """

    def __init__(self, settings: BoxSettings) -> None:
        widest = np.array(settings.rest_volumes) + WIDEST_GROWTH
        self._per_mass = GAS_CONSTANT * settings.temperature / widest  # [Pa/kg]
        self._least_gauge = float(settings.zero_band)
        self._rehearse(np.zeros_like(widest))
        self.restart()

    def _rehearse(self, zeros: Floats) -> None:
        """Let the kernel be compiled, or loaded, before a sample waits for it."""
        self.restart()
        self._counting[:] = True
        self.look(0.0, zeros, zeros, 0.0, self._valves, zeros, zeros)

    def restart(self) -> None:
        """Forget all evidence."""
        n = len(self._per_mass)
        self.idle: Flags = np.zeros(n, dtype=bool)
        self.unvented: Flags = np.zeros(n, dtype=bool)
        self._valves: Valves = np.zeros(n, dtype=np.int8)
        self._since: Floats = np.full(n, np.inf)  # the valve was switched last [s]
        self._counting: Flags = np.zeros(n, dtype=bool)  # a pulse is under way, or settles
        self._acted: Flags = np.zeros(n, dtype=bool)  # the pulse has moved the pressure
        self._direction: Valves = np.zeros(n, dtype=np.int8)  # of the pulses summed up
        self._start: Floats = np.zeros(n)  # pressure from which the pulse is judged [Pa]
        self._start_noise: Floats = np.zeros(n)  # of that pressure, one sigma [Pa]
        self._mass: Floats = np.zeros(n)  # estimate at that time [kg]
        self._due: Floats = np.zeros(n)  # expected of the pulse so far [Pa]
        self._whole: Floats = np.zeros(n)  # expected of it once it has settled [Pa]
        self._owed: Floats = np.zeros(n)  # expected of the pulses before it [Pa]
        self._shift: Floats = np.zeros(n)  # what those did [Pa]
        self._peak: Floats = np.zeros(n)  # from which an open outlet must lower the pressure [Pa]
        self._outrun: Floats = np.zeros(n)  # expected of the outlet since that peak [Pa]

    def look(
        self,
        dt: float,
        gauge: Floats,
        noise: Floats,
        supply: float,
        valves: Valves,
        flow: Floats,
        mass: Floats,
    ) -> None:
        """Take one sample.

        Args:
            dt: time since the last sample [s].
            noise: of these pressures, one sigma (n,) [Pa].
            gauge: pressures, low-passed (n,) [Pa].
            supply: gauge pressure of the supply [Pa].
            valves: commanded during `dt` (n,).
            flow: into the channels, as predicted for these valves (n,) [kg/s].
            mass: estimated, with what the pulses under way will have moved (n,) [kg].
        """
        changed = valves != self._valves
        if changed.any():
            self._switch(changed, gauge, noise, valves, mass)
        self._since += dt
        if not self._counting.any():
            return
        settled = _weigh(
            dt,
            supply,
            self._least_gauge,
            (gauge, noise, flow, mass),
            (self._valves, self._since, self._per_mass),
            (self._counting, self._acted, self.idle, self.unvented),
            (self._start, self._start_noise, self._mass),
            (self._due, self._whole, self._owed, self._shift, self._peak, self._outrun),
        )
        if settled.any():
            self._close_books(settled, gauge)

    def _switch(
        self, changed: Flags, gauge: Floats, noise: Floats, valves: Valves, mass: Floats
    ) -> None:
        begun = changed & (valves != 0)
        if begun.any():
            self._close_books(begun & self._counting, gauge)
            turned = begun & (valves != self._direction)
            self._forget(turned)
            self._set_start(begun, gauge, noise, mass)
            self._direction = np.where(begun, valves, self._direction)
            self._peak = np.where(begun, gauge, self._peak)
            self._outrun[begun] = 0.0
            self._acted &= ~begun
            self._counting |= begun
        self._since[changed] = 0.0
        self._valves = valves.copy()

    def _close_books(self, done: Flags, gauge: Floats) -> None:
        """Add pulses that have settled to those before them; one that has acted ends their sum."""
        self._owed += done * np.maximum(self._due, self._whole)
        self._shift += np.where(done, gauge - self._start, 0.0)
        self.idle |= done & (self._owed >= EXPECTED)
        acted = done & self._acted
        self._owed[acted] = self._shift[acted] = 0.0
        self._due[done] = self._whole[done] = 0.0
        self._counting &= ~done

    def _forget(self, cleared: Flags) -> None:
        for evidence in (self._owed, self._shift, self._due, self._whole):
            evidence[cleared] = 0.0

    def _set_start(self, channels: Flags, gauge: Floats, noise: Floats, mass: Floats) -> None:
        self._start = np.where(channels, gauge, self._start)
        self._start_noise = np.where(channels, noise, self._start_noise)
        self._mass = np.where(channels, mass, self._mass)


@compiled
def _weigh(
    dt: float,
    supply: float,
    least_gauge: float,
    seen: Any,
    given: Any,
    flags: Any,
    start: Any,
    sums: Any,
) -> Flags:
    """Weigh a sample, channel by channel; the state is changed in place.

    Returns:
        Channels whose pulse has settled (n,).
    """
    gauges, noises, flows, masses = seen
    valves, since, per_mass = given
    counting, acted, idle, unvented = flags
    start_gauge, start_noise, start_mass = start
    due, whole, owed, shift, peak, outrun = sums
    settled = np.zeros(len(gauges), dtype=np.bool_)
    for i in range(len(gauges)):
        gauge, valve = gauges[i], valves[i]
        if valve > 0:
            reach = supply - gauge > LEAST_DROP and gauge > RANGE_END
        else:
            reach = gauge > least_gauge
        expected = 0.0
        if reach and since[i] > LATENCY:
            expected = dt * max(valve * flows[i], 0.0) * per_mass[i]
        due[i] += expected
        if valve != 0:
            late = reach and since[i] > OPENING
            whole[i] = abs(masses[i] - start_mass[i]) * per_mass[i] if late else 0.0
        # a fifth of what is expected is no effect either; see EXPECTED
        share = min((owed[i] + due[i]) * (UNMOVED / EXPECTED), UNMOVED)
        shown = min(max(SIGMAS * math.hypot(noises[i], start_noise[i]), LEAST_NOISE), UNMOVED)
        moved = abs(shift[i] + gauge - start_gauge[i]) > max(shown, share)
        if counting[i] and moved:
            owed[i] = shift[i] = due[i] = whole[i] = 0.0
            idle[i], acted[i] = False, True
            start_gauge[i], start_noise[i], start_mass[i] = gauge, noises[i], masses[i]
        if counting[i] and owed[i] + due[i] >= WHILE_OPEN * EXPECTED:
            idle[i] = True
        peak[i] = max(peak[i], gauge)
        falls = gauge < peak[i] - UNMOVED
        if falls:
            peak[i] = gauge
        outrun[i] = 0.0 if falls or valve >= 0 else outrun[i] + expected
        unvented[i] = valve < 0 and gauge > least_gauge and outrun[i] >= WHILE_OPEN * EXPECTED
        settled[i] = counting[i] and valve == 0 and since[i] > SETTLING
    return settled
