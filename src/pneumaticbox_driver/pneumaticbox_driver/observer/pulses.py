"""Regressors of equation 4.1 for the running pulses, from samples at any time intervals.

All computations at every sample are compiled: at 500 Hz the caches are cold, so that many small
calls of numpy would take the most time. All arrays have the channels in order (n,).
"""

import math
from typing import Any

import numpy as np

from pneumaticbox_driver.arrays import Flags, Floats, Valves
from pneumaticbox_driver.observer.coefficients import VALVE_DELAY, flow_rates
from softhand_common.numerics.compiled import compiled
from softhand_model.gas import AMBIENT_PRESSURE, CRITICAL_RATIO, HEAT_CAPACITY_RATIO

RATIO_EXPONENT = 1 / HEAT_CAPACITY_RATIO
FLOW_EXPONENT = HEAT_CAPACITY_RATIO / (HEAT_CAPACITY_RATIO - 1)
ROUNDING = 1e-9  # of times [s]


@compiled
def injector_rate(upstream: float, downstream: float) -> float:
    """Integrand of the injector term [Pa], as in `flow_rates`."""
    high, low = max(upstream, downstream), min(upstream, downstream)
    ratio = min(max(low / high, CRITICAL_RATIO), 1.0)
    root = ratio**RATIO_EXPONENT
    return math.copysign(
        high * math.sqrt(FLOW_EXPONENT * root * (root - ratio)), upstream - downstream
    )


@compiled
def integrate_pulses(
    dt: float,
    pressures_abs: Floats,
    ends: tuple[float, float, float],
    is_open: Flags,
    inflating: Flags,
    delays: Floats,
    clock: Floats,
    sums: Any,
) -> None:
    """Integrate the terms of equation 4.1 over the last `dt` [s] with linear rates.

    Args:
        dt: time since the last sample, above 0 [s].
        pressures_abs: present absolute pressures of the channels (n,) [Pa].
        ends: absolute supply and ambient pressure, and the drop below which the outflow is taken as
            zero [Pa].
        is_open: channels whose valve is commanded open (n,).
        inflating: channels whose pulse inflates (n,).
        delays: delays of opening and closing (2, n) [s].
        clock: age and commanded length of the pulses (2, n), updated in place [s].
        sums: `rates` (2, n), `passed` (2, n) and `values` (5, n), updated in place.
    """
    supply_abs, ambient, unseen = ends
    rates, passed, values = sums
    for i in range(len(pressures_abs)):
        upstream = supply_abs if inflating[i] else pressures_abs[i]
        downstream = pressures_abs[i] if inflating[i] else ambient
        if is_open[i] and inflating[i]:
            values[3, i] = supply_abs
        elif not inflating[i] and abs(upstream - ambient) < unseen:
            upstream = ambient
        start = clock[0, i]
        now = start + dt
        clock[0, i] = now
        if is_open[i]:
            clock[1, i] = now
        opening = delays[0, i]
        end = clock[1, i] + delays[1, i]
        first = min(max(opening, start), now)
        last = max(min(end, now), first)
        middle = (0.5 * (first + last) - start) / dt
        to_come = max(end - max(now, opening), 0.0)
        for row in range(2):
            rate = injector_rate(upstream, downstream) if row else upstream - downstream
            passed[row, i] += (last - first) * (rates[row, i] + middle * (rate - rates[row, i]))
            values[row + 1, i] = passed[row, i] + to_come * rate
            rates[row, i] = rate


@compiled
def sum_terms(
    coefficients: Floats, values: Floats, rates: Floats, sign: Floats, direction: Any, found: Floats
) -> None:
    """Equation 4.1 of the running pulses: moved mass [kg] and flow [kg/s] into `found` (2, n).

    Args:
        coefficients: coefficients of the pulses (5, n).
        values: values of the terms (5, n).
        rates: present integrands (2, n) [Pa].
        sign: +1 for inflation, -1 for deflation, 0 without a pulse (n,).
        direction: presently commanded (n,).
        found: result (2, n).
    """
    for i in range(len(sign)):
        mass = 0.0
        for term in range(5):
            mass += coefficients[term, i] * values[term, i]
        found[0, i] = sign[i] * max(mass, 0.0)
        flow = coefficients[1, i] * rates[0, i] + coefficients[2, i] * rates[1, i]
        found[1, i] = direction[i] * flow


@compiled
def follow_pulses(
    dt: float,
    pressures_abs: Floats,
    ends: tuple[float, float, float],
    courses: Any,
    sums: Any,
    pulses: Any,
    found: Floats,
    ended: Flags,
) -> bool:
    """Run `integrate_pulses`, if time has passed, and `sum_terms`; returns whether a pulse has
    `ended` (n,).

    Args:
        dt, ends, sums: as in `integrate_pulses`.
        pressures_abs: present absolute pressures of the channels (n,) [Pa].
        courses: `is_open`, `inflating`, `delays` and `clock` of `integrate_pulses`.
        pulses: `coefficients`, `sign` and `direction` of `sum_terms`.
        found: as in `sum_terms`.
        ended: result, marks the pulses that have ended (n,).
    """
    is_open, inflating, delays, clock = courses
    coefficients, sign, direction = pulses
    if dt > 0:
        integrate_pulses(dt, pressures_abs, ends, is_open, inflating, delays, clock, sums)
    rates, _, values = sums
    sum_terms(coefficients, values, rates, sign, direction, found)
    some = False
    for i in range(len(sign)):
        flowing = is_open[i] or clock[0, i] < clock[1, i] + delays[1, i] - ROUNDING
        ended[i] = sign[i] != 0 and not flowing
        some |= ended[i]
    return some


@compiled
def predict_pulses(
    duration: float,
    pressures_abs: Floats,
    ends: tuple[float, float],
    coefficients: Any,
    delays: Any,
    found: Floats,
) -> None:
    """Equation 4.1 of future pulses at constant pressures: masses [kg] into `found` (2, n).

    Args:
        duration: duration of the pulses [s].
        pressures_abs: absolute pressures of the channels (n,) [Pa].
        ends: absolute supply and ambient pressure [Pa].
        coefficients: coefficients of inflation and of deflation, (5, n) each.
        delays: delays of opening and closing (2, n), of inflation and of deflation [s].
        found: result (2, n): added mass of an inflation, removed mass of a deflation.
    """
    for way in range(2):
        c, delay = coefficients[way], delays[way]
        for i in range(len(pressures_abs)):
            upstream = pressures_abs[i] if way else ends[0]
            downstream = ends[1] if way else pressures_abs[i]
            flow = c[1, i] * (upstream - downstream)
            flow += c[2, i] * injector_rate(upstream, downstream)
            length = max(duration + delay[1, i] - delay[0, i], 0.0)
            mass = c[0, i] + length * flow + c[3, i] * upstream + c[4, i] * downstream
            found[way, i] = max(mass, 0.0)


class PulseIntegrals:
    """Integrates the terms of equation 4.1 per channel, for observer and calibration.

    Because of the valve's delays, air flows from `t_on` + opening delay to `t_off` + closing delay,
    which are the bounds of the integrals. The future part is computed with the present rate and
    replaced by measurements until the valve has closed. With the printed bounds, `t_on` to `t_off`,
    the flow would be taken before the valve opens and missed before it closes, which matters when
    the pressure changes much, as in a small volume.

    The dead volume of an inlet keeps air at the supply pressure at the closing of the valve, so
    that during inflation the switching term has `p_in` at switch-off, not at `t_on` as printed.
    Otherwise a calibration, in which all channels open together and lower the supply pressure,
    would give coefficients for such a drop only.

    `values` (5, n) are 1, the friction and the injector integral [Pa s], and the pressures
    upstream and downstream for the switching terms [Pa]; `rates` (2, n) are the present integrands
    [Pa]; both are updated in place.

    Args:
        channels: number of channels.
        ambient: absolute ambient pressure [Pa].
        unseen: drop to ambient pressure below which the outflow is taken as zero [Pa].
    """

    def __init__(
        self, channels: int, ambient: float = AMBIENT_PRESSURE, unseen: float = 0.0
    ) -> None:
        self.ambient = ambient
        self._unseen = unseen
        self._delays: Floats = np.full((2, channels), VALVE_DELAY)
        self.values: Floats = np.zeros((5, channels))
        self.rates: Floats = np.zeros((2, channels))
        # time since switch-on, and commanded length so far [s]
        self._clock: Floats = np.array([np.full(channels, VALVE_DELAY), np.zeros(channels)])
        self._passed: Floats = np.zeros((2, channels))  # integrals of what has flowed
        self._open: Flags = np.zeros(channels, dtype=bool)
        self._inflating: Flags = np.zeros(channels, dtype=bool)

    @property
    def lengths(self) -> Floats:
        """Commanded durations so far (n,) [s]."""
        return self._clock[1]

    @property
    def flowing(self) -> Flags:
        """Channels whose pulse has not ended: open, or switched off and not closed yet (n,)."""
        return self._open | (self._clock[0] < self._clock[1] + self._delays[1] - ROUNDING)

    def begin(
        self,
        begun: Flags,
        valves: Valves,
        pressures_abs: Floats,
        supply_abs: float,
        delays: Floats | None = None,
    ) -> None:
        """Start pulses on the channels `begun` (n,), now that `valves` (n,) are commanded.

        `pressures_abs` (n,) and `supply_abs` are absolute [Pa]; `delays` (2, n) of opening and
        closing [s], None for the nominal ones.
        """
        given = np.full_like(self._delays, VALVE_DELAY) if delays is None else delays
        self._delays = np.where(begun, given, self._delays)
        self._inflating = np.where(begun, valves > 0, self._inflating)
        self._open = self._open | begun
        upstream, downstream = self._ends(pressures_abs, supply_abs)
        zeros = np.zeros_like(pressures_abs)
        start = np.array([zeros + 1.0, zeros, zeros, upstream, downstream])
        self.values = np.where(begun, start, self.values)
        self._passed = np.where(begun, 0.0, self._passed)
        self._clock = np.where(begun, 0.0, self._clock)
        self.rates = np.array(flow_rates(upstream, downstream))

    def end(self, ended: Flags) -> None:
        """Switch off the valves of the channels `ended` (n,)."""
        self._open = self._open & ~ended

    def advance(self, dt: float, pressures_abs: Floats, supply_abs: float) -> None:
        """Integrate over the last `dt` [s] with linear rates, to these absolute pressures [Pa]."""
        if dt <= 0:
            return
        integrate_pulses(
            dt,
            pressures_abs,
            (supply_abs, self.ambient, self._unseen),
            self._open,
            self._inflating,
            self._delays,
            self._clock,
            (self.rates, self._passed, self.values),
        )

    def follow(self, dt: float, pressures_abs: Floats, supply_abs: float, pulses: Any) -> Any:
        """Integrate as `advance` does, and evaluate equation 4.1.

        Args:
            dt: time since the last sample, 0 or above [s].
            pressures_abs: present absolute pressures of the channels (n,) [Pa].
            supply_abs: absolute supply pressure [Pa].
            pulses: `coefficients` (5, n), `sign` (n,) and `direction` (n,) of `sum_terms`.

        Returns:
            Moved masses [kg] and flows [kg/s] (2, n); marks of the pulses that have ended (n,),
            None if none has.
        """
        n = len(pressures_abs)
        found, ended = np.empty((2, n)), np.empty(n, dtype=bool)
        ends = supply_abs, self.ambient, self._unseen
        courses = self._open, self._inflating, self._delays, self._clock
        sums = self.rates, self._passed, self.values
        some = follow_pulses(dt, pressures_abs, ends, courses, sums, pulses, found, ended)
        return found, ended if some else None

    def _ends(self, pressures_abs: Floats, supply_abs: float) -> tuple[Floats, Floats]:
        upstream = np.where(self._inflating, supply_abs, pressures_abs)
        return upstream, np.where(self._inflating, pressures_abs, self.ambient)
