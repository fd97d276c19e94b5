"""What the observer does at every sample, compiled: the same as its numpy, with one call each.

A sample of 500 Hz leaves the processor cold, so the many small calls of numpy are what it takes
longest over. All arrays have the channels in order (n,), units as in `PulseIntegrals`.
"""

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from softhand_model.compiled import compiled
from softhand_model.gas import CRITICAL_RATIO, HEAT_CAPACITY_RATIO

Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]
ROOT = 1 / HEAT_CAPACITY_RATIO
EXPONENT = HEAT_CAPACITY_RATIO / (HEAT_CAPACITY_RATIO - 1)


@compiled
def injector_rate(upstream: float, downstream: float) -> float:
    """Integrand of the injector term, as `flow_model.flow_rates` has it [Pa]."""
    high, low = max(upstream, downstream), min(upstream, downstream)
    ratio = min(max(low / high, CRITICAL_RATIO), 1.0)
    root = ratio**ROOT
    return math.copysign(high * math.sqrt(EXPONENT * root * (root - ratio)), upstream - downstream)


@compiled
def integrate_pulses(
    dt: float,
    pressures: Floats,
    ends: tuple[float, float],
    is_open: Flags,
    inflating: Flags,
    delays: Floats,
    clock: Floats,
    sums: Any,
) -> None:
    """Integrate the terms of equation 4.1 over the last `dt` [s], rates linear in between.

    Args:
        dt: since the last sample, above 0 [s].
        pressures: of the channels now, absolute (n,) [Pa].
        ends: supply and ambient pressure [Pa].
        is_open: channels whose valve is commanded open (n,).
        inflating: channels whose pulse inflates (n,).
        delays: of opening and closing (2, n) [s].
        clock: age and commanded length of the pulses (2, n), brought up to now [s].
        sums: `rates` (2, n), `passed` (2, n) and `values` (5, n), brought up to now.
    """
    supply, ambient = ends
    rates, passed, values = sums
    for i in range(len(pressures)):
        upstream = supply if inflating[i] else pressures[i]
        downstream = pressures[i] if inflating[i] else ambient
        if is_open[i] and inflating[i]:
            values[3, i] = supply
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
    """Equation 4.1 of the pulses under way: moved mass [kg] and flow [kg/s] into `found` (2, n).

    Args:
        coefficients: of the pulses (5, n).
        values: of the terms (5, n).
        rates: present integrands (2, n) [Pa].
        sign: +1 of a pulse that inflates, -1 of one that deflates, 0 of none (n,).
        direction: that is commanded now (n,).
        found: is written to (2, n).
    """
    for i in range(len(sign)):
        mass = 0.0
        for term in range(5):
            mass += coefficients[term, i] * values[term, i]
        found[0, i] = sign[i] * max(mass, 0.0)
        flow = coefficients[1, i] * rates[0, i] + coefficients[2, i] * rates[1, i]
        found[1, i] = direction[i] * flow


@compiled
def predict_pulses(
    duration: float,
    pressures: Floats,
    ends: tuple[float, float],
    coefficients: Any,
    delays: Any,
    found: Floats,
) -> None:
    """Equation 4.1 of pulses to come, at constant pressures: masses [kg] into `found` (2, n).

    Args:
        duration: of the pulses [s].
        pressures: of the channels, absolute (n,) [Pa].
        ends: supply and ambient pressure [Pa].
        coefficients: of inflation and of deflation, (5, n) each.
        delays: of opening and closing (2, n), of inflation and of deflation [s].
        found: what a pulse brings, and what one takes, is written to (2, n).
    """
    for way in range(2):
        c, delay = coefficients[way], delays[way]
        for i in range(len(pressures)):
            upstream = pressures[i] if way else ends[0]
            downstream = ends[1] if way else pressures[i]
            flow = c[1, i] * (upstream - downstream)
            flow += c[2, i] * injector_rate(upstream, downstream)
            length = max(duration + delay[1, i] - delay[0, i], 0.0)
            mass = c[0, i] + length * flow + c[3, i] * upstream + c[4, i] * downstream
            found[way, i] = max(mass, 0.0)
