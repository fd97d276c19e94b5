"""Delays of a valve from the measured pressure, which steps when the flow begins and ends."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pneumaticbox_driver.arrays import Floats
from pneumaticbox_driver.observer.coefficients import NOMINAL_DELAYS, VALVE_DELAY, Delays

TRACE_TIMES = np.arange(-0.018, 0.0801, 0.001)  # times from the command [s]
OPEN_FOR_SURE = (0.05, 0.064)  # times after switch-on at which every valve is open [s]
NOT_YET_CLOSED = (0.0, 0.018)  # times after switch-off at which a slow valve is open [s]
STILL_SWITCHED_ON = (-0.018, 0.0)  # the same for a fast valve [s]
ESTABLISHED = 0.06  # length of a pulse from which on its flow is established at the end [s]
LEAST_STEP = 6.0  # of the pressure, in standard errors of the averaged curve
LONGEST_DELAY = 0.06  # longer ones are measurement errors [s]


@dataclass(frozen=True)
class PulseTrace:
    """Pressure of one channel over a pulse.

    `times` (samples,) from switch-on [s], `pressures_abs` (samples,) [Pa]; `length` of the command
    [s]; `before` and `after` the pressures at rest [Pa] and `direction` +1 or -1.
    """

    times: Floats
    pressures_abs: Floats
    length: float
    before: float
    after: float
    direction: int


def valve_delays(traces: Sequence[PulseTrace], noise: float) -> Delays:
    """Delays of opening and closing, from pressures averaged over pulses.

    The sensor is in the box: its reading includes the pressure drop along the tube from the opening
    to the closing of the valve. The delay is the time at half of the step of the reading.

    During inflation the air of the dead volume blurs the second step. As the flow then hardly
    depends on the channel's pressure, the effect of the closing delay is contained in the switching
    terms, and the opening delay is used for both.

    Args:
        traces: pulses of one channel and direction.
        noise: standard deviation of a pressure sample [Pa].

    Returns:
        The delays of opening and closing [s]; the nominal ones without a clear step.
    """
    if not traces:
        return NOMINAL_DELAYS
    opening = _mean_trace([(t.times, t.direction * (t.pressures_abs - t.before)) for t in traces])
    opened = _crossing(opening, OPEN_FOR_SURE, noise / np.sqrt(len(traces)), rising=True)
    if traces[0].direction > 0:
        return opened, opened
    lasting = [t for t in traces if t.length >= ESTABLISHED] or traces
    closing = _mean_trace(
        [(t.times - t.length, t.direction * (t.pressures_abs - t.after)) for t in lasting]
    )
    error = noise / np.sqrt(len(lasting))
    closed = _crossing(closing, STILL_SWITCHED_ON, error, rising=False)
    if max(opened, closed) >= NOT_YET_CLOSED[1]:
        closed = _crossing(closing, NOT_YET_CLOSED, error, rising=False)
    return opened, closed


def _mean_trace(curves: Sequence[tuple[Floats, Floats]]) -> Floats:
    return np.mean([np.interp(TRACE_TIMES, times, values) for times, values in curves], axis=0)


def _crossing(curve: Floats, flowing: tuple[float, float], error: float, rising: bool) -> float:
    """Time at which a curve over TRACE_TIMES crosses half of its linear fit during the flow."""
    sure = (flowing[0] <= TRACE_TIMES) & (flowing[1] >= TRACE_TIMES)
    slope, level = np.polyfit(TRACE_TIMES[sure], curve[sure], 1)
    half = 0.5 * (level + slope * TRACE_TIMES)
    there = np.clip(TRACE_TIMES[sure].mean(), 0.0, LONGEST_DELAY)
    if 2 * np.interp(there, TRACE_TIMES, half) < LEAST_STEP * error:
        return VALVE_DELAY
    excess = curve - half
    if rising:
        before = np.flatnonzero((excess < 0) & (flowing[0] > TRACE_TIMES))
        first = int(before[-1]) if len(before) else -1
    else:
        after = np.flatnonzero((excess < 0) & (flowing[1] < TRACE_TIMES))
        first = int(after[0]) - 1 if len(after) else -1
    if first < 0:
        return VALVE_DELAY
    share = excess[first] / (excess[first] - excess[first + 1])
    time = float(TRACE_TIMES[first] + share * (TRACE_TIMES[first + 1] - TRACE_TIMES[first]))
    return time if 0.0 < time < LONGEST_DELAY else VALVE_DELAY
