"""Effect of pulses: compares the commanded pulses with the changes of the pressures."""

import math
from typing import Any, NamedTuple

import numpy as np

from pneumaticbox_driver.arrays import Flags, Floats, Valves, same, some
from pneumaticbox_driver.settings import BoxSettings
from softhand_common.numerics.compiled import compiled
from softhand_model.gas import GAS_CONSTANT

PRESSURE_SMOOTHING = 0.03  # low-pass of the pressures: 60 Pa of noise become 15 at 500 Hz [s]
# Largest compliance of a channel. Mass is conserved, so that a pulse of mass m raises the pressure
# by at least m R T over the volume plus p dV/dp. Half a litre is ten times the growth of a
# finger's channel, and the volume of the bottle in a calibration.
WIDEST_GROWTH = 0.5e-3  # [m3]
# A pulse shorter than the opening delay of the slowest valve may move no air.
SLOWEST_OPENING = 0.04  # [s]
# Time after which a pulse has an effect: slowest valve, low-pass, one sample.
LATENCY = 0.08  # [s]
EFFECT_SETTLING = 0.1  # after a pulse, for the closing delay, dead volume and low-pass [s]
MOTION_SIGMAS = 4.0  # of noise, above which a change is a motion
LEAST_NOISE = 61.0  # the step of a 12-bit converter for 250 kPa [Pa]
# Largest change of a low-passed constant pressure: 2.5 sigma of a difference with three times the
# noise of Table 4.1 at samples 10 ms apart.
UNMOVED = 240.0  # [Pa]
# Five times that: even if the flow is overestimated fivefold, by a calibration of other chokes in
# the widest volume, the decision is right.
EXPECTED_EFFECT = 1200.0  # [Pa]
# While a valve is open, a hand that opens or closes may keep the pressure constant, which shows
# after the valve has closed. Until then four times the evidence is required: 30 mg, about the air
# mass of a finger.
WHILE_OPEN = 4.0
# Below this pressure drop, errors of the sensors of the supply (2.5 % of 700 kPa) and of the
# channel (1.4 % of 250 kPa) could amount to half of it.
LEAST_DROP = 42e3  # from the supply into a channel [Pa]
# No error within the class of the sensor gives such a reading at ambient pressure: it is saturated.
RANGE_END = -3500.0  # gauge [Pa]


class Seen(NamedTuple):
    """State of the channels (n,): low-passed gauge pressures [Pa] and their noise, one sigma [Pa],
    the predicted flow into them [kg/s], and the estimated mass at the end of the running pulses
    [kg].
    """

    pressures: Floats
    noise: Floats
    flow: Floats
    mass: Floats


class _Valve(NamedTuple):
    state: Valves  # as commanded (n,)
    since: Floats  # time since it was switched [s]
    per_mass: Floats  # pressure per moved air mass, in the widest channel [Pa/kg]


class _Marks(NamedTuple):
    counting: Flags  # a pulse is running or settling
    acted: Flags  # the pulse has changed the pressure
    idle: Flags
    unvented: Flags


class _Start(NamedTuple):
    pressures: Floats  # at the start of the pulse [Pa]
    noise: Floats  # of them, one sigma [Pa]
    mass: Floats  # estimate at that time [kg]


class _Sums(NamedTuple):  # all in [Pa]
    due: Floats  # expected change by the pulse so far
    whole: Floats  # expected change by the pulse after settling
    owed: Floats  # expected change by the pulses before it
    shift: Floats  # measured change by the pulses before it
    peak: Floats  # pressure from which an open outlet must lower it
    outrun: Floats  # expected change by the outlet since that peak


class PulseEffect:
    """Sums the smallest change of pressure that pulses must cause, which is that in a channel of
    the largest possible volume.

    `idle` (n,) marks channels whose pressure was constant during pulses that must change it,
    `unvented` (n,) those whose pressure does not fall with the outlet commanded open. A change of
    pressure clears the first mark, falling pressure the second. An external force can hide a fault
    while it lasts; to cause a false mark it would have to cancel a pulse exactly.

    Args:
        settings: settings of the box.
    """

    def __init__(self, settings: BoxSettings) -> None:
        widest = np.array(settings.rest_volumes) + WIDEST_GROWTH
        self._per_mass = GAS_CONSTANT * settings.temperature / widest  # [Pa/kg]
        self._least_pressure = float(settings.zero_band)
        self._rehearse(np.zeros_like(widest))
        self.restart()

    def _rehearse(self, zeros: Floats) -> None:
        """Compile or load the kernel before the first sample."""
        self.restart()
        self._marks.counting[:] = True
        self.look(0.0, Seen(zeros, zeros, zeros, zeros), 0.0, self._valve.state)

    def restart(self) -> None:
        """Clear all evidence."""
        n = len(self._per_mass)
        self._valve = _Valve(np.zeros(n, dtype=np.int8), np.full(n, np.inf), self._per_mass)
        self._direction: Valves = np.zeros(n, dtype=np.int8)  # of the pulses summed up
        self._marks = _Marks(*np.zeros((4, n), dtype=bool))
        self._start = _Start(*np.zeros((3, n)))
        self._sums = _Sums(*np.zeros((6, n)))
        self._groups = [tuple(g) for g in (self._valve, self._marks, self._start, self._sums)]
        self.idle, self.unvented = self._marks.idle, self._marks.unvented

    def look(self, dt: float, seen: Seen, supply: float, valves: Valves) -> None:
        """Add one sample.

        Args:
            dt: time since the last sample [s].
            seen: state of the channels.
            supply: gauge pressure of the supply [Pa].
            valves: valves commanded during `dt` (n,).
        """
        if not same(valves, self._valve.state):
            self._switch(valves != self._valve.state, seen, valves)
        np.add(self._valve.since, dt, out=self._valve.since)
        if not some(self._marks.counting):
            return
        settled = _weigh(dt, supply, self._least_pressure, tuple(seen), *self._groups)
        if some(settled):
            self._close_books(settled, seen.pressures)

    def _switch(self, changed: Flags, seen: Seen, valves: Valves) -> None:
        begun = changed & (valves != 0)
        if some(begun):
            self._close_books(begun & self._marks.counting, seen.pressures)
            for evidence in self._sums[:4]:
                evidence[begun & (valves != self._direction)] = 0.0
            for kept, now in zip(self._start, (seen.pressures, seen.noise, seen.mass), strict=True):
                kept[begun] = now[begun]
            self._direction[begun] = valves[begun]
            self._sums.peak[begun] = seen.pressures[begun]
            self._sums.outrun[begun] = 0.0
            self._marks.acted[begun] = False
            self._marks.counting[begun] = True
        self._valve.since[changed] = 0.0
        self._valve.state[:] = valves

    def _close_books(self, done: Flags, pressures: Floats) -> None:
        """Add settled pulses to the sums; a pulse with an effect clears them."""
        sums, marks = self._sums, self._marks
        sums.owed[done] += np.maximum(sums.due, sums.whole)[done]
        sums.shift[done] += (pressures - self._start.pressures)[done]
        marks.idle[done & (sums.owed >= EXPECTED_EFFECT)] = True
        acted = done & marks.acted
        sums.owed[acted] = sums.shift[acted] = 0.0
        sums.due[done] = sums.whole[done] = 0.0
        marks.counting[done] = False


@compiled
def _weigh(
    dt: float,
    supply: float,
    least_pressure: float,
    seen: Any,
    commanded: Any,
    marks: Any,
    start: Any,
    sums: Any,
) -> Flags:
    """Evaluate a sample for each channel; marks, start and sums are changed in place.

    The groups are plain tuples in the order of `Seen`, `_Valve`, `_Marks`, `_Start` and `_Sums`:
    passing named tuples would take longer than the kernel itself.

    Returns:
        Channels whose pulse has settled (n,).
    """
    pressures, noises, flows, masses = seen
    valves, since, per_mass = commanded
    counting, acted, idle, unvented = marks
    start_pressure, start_noise, start_mass = start
    due, whole, owed, shift, peak, outrun = sums
    settled = np.zeros(len(pressures), dtype=np.bool_)
    for i in range(len(pressures)):
        pressure, valve = pressures[i], valves[i]
        if valve > 0:
            reach = supply - pressure > LEAST_DROP and pressure > RANGE_END
        else:
            reach = pressure > least_pressure
        expected = 0.0
        if reach and since[i] > LATENCY:
            expected = dt * max(valve * flows[i], 0.0) * per_mass[i]
        due[i] += expected
        if valve != 0:
            late = reach and since[i] > SLOWEST_OPENING
            whole[i] = abs(masses[i] - start_mass[i]) * per_mass[i] if late else 0.0
        # less than a fifth of the expected change is no effect, either; see EXPECTED_EFFECT
        share = min((owed[i] + due[i]) * (UNMOVED / EXPECTED_EFFECT), UNMOVED)
        shown = min(
            max(MOTION_SIGMAS * math.hypot(noises[i], start_noise[i]), LEAST_NOISE), UNMOVED
        )
        moved = abs(shift[i] + pressure - start_pressure[i]) > max(shown, share)
        if counting[i] and moved:
            owed[i] = shift[i] = due[i] = whole[i] = 0.0
            idle[i], acted[i] = False, True
            start_pressure[i], start_noise[i], start_mass[i] = pressure, noises[i], masses[i]
        if counting[i] and owed[i] + due[i] >= WHILE_OPEN * EXPECTED_EFFECT:
            idle[i] = True
        peak[i] = max(peak[i], pressure)
        falls = pressure < peak[i] - UNMOVED
        if falls:
            peak[i] = pressure
        outrun[i] = 0.0 if falls or valve >= 0 else outrun[i] + expected
        unvented[i] = (
            valve < 0 and pressure > least_pressure and outrun[i] >= WHILE_OPEN * EXPECTED_EFFECT
        )
        settled[i] = counting[i] and valve == 0 and since[i] > EFFECT_SETTLING
    return settled
