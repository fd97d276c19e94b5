"""Delays of a valve, read from the pressure: a step where the flow begins, one where it ends."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pneumaticbox_driver.arrays import Floats
from pneumaticbox_driver.observer.coefficients import NOMINAL_DELAYS, VALVE_DELAY, Delays

GRID = np.arange(-0.018, 0.0801, 0.001)  # times from the command [s]
OPEN_FOR_SURE = (0.05, 0.064)  # after switch-on, opened and not closed again yet [s]
NOT_YET_CLOSED = (0.0, 0.018)  # after switch-off, of a valve that takes longer to close [s]
STILL_SWITCHED_ON = (-0.018, 0.0)  # for one that does not [s]
ESTABLISHED = 0.06  # least length of a pulse whose flow is established at its end [s]
LEAST_STEP = 6.0  # of the pressure, in standard errors of the averaged course
MOST = 0.06  # a longer delay is not one of such a valve [s]


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
    """Delays of opening and closing, from the courses of the pressure averaged over pulses.

    The sensor sits in the box, so that it sees the drop along the tube as soon as air flows and
    no longer when the valve has closed. The delay is where half of that step has been made.

    Inflating, the air of the dead volume blurs the second step; but as the flow hardly depends
    on the channel's pressure then, what the closing adds is all in the switching terms, and the
    opening's delay stands for both.

    Args:
        traces: pulses of one channel and direction.
        noise: of a pressure sample, one sigma [Pa].

    Returns:
        The delays of opening and closing [s]; the nominal ones where there is no clear step.
    """
    if not traces:
        return NOMINAL_DELAYS
    opening = _mean_course([(t.times, t.direction * (t.pressures_abs - t.before)) for t in traces])
    opened = _crossing(opening, OPEN_FOR_SURE, noise / np.sqrt(len(traces)), rising=True)
    if traces[0].direction > 0:
        return opened, opened
    lasting = [t for t in traces if t.length >= ESTABLISHED] or traces
    closing = _mean_course(
        [(t.times - t.length, t.direction * (t.pressures_abs - t.after)) for t in lasting]
    )
    error = noise / np.sqrt(len(lasting))
    closed = _crossing(closing, STILL_SWITCHED_ON, error, rising=False)
    if max(opened, closed) >= NOT_YET_CLOSED[1]:
        closed = _crossing(closing, NOT_YET_CLOSED, error, rising=False)
    return opened, closed


def _mean_course(courses: Sequence[tuple[Floats, Floats]]) -> Floats:
    return np.mean([np.interp(GRID, times, values) for times, values in courses], axis=0)


def _crossing(course: Floats, flowing: tuple[float, float], error: float, rising: bool) -> float:
    """Time at which a course (GRID) crosses half of the line that it follows while air flows."""
    sure = (flowing[0] <= GRID) & (flowing[1] >= GRID)
    slope, level = np.polyfit(GRID[sure], course[sure], 1)
    half = 0.5 * (level + slope * GRID)
    there = np.clip(GRID[sure].mean(), 0.0, MOST)
    if 2 * np.interp(there, GRID, half) < LEAST_STEP * error:
        return VALVE_DELAY
    excess = course - half
    if rising:
        before = np.flatnonzero((excess < 0) & (flowing[0] > GRID))
        first = int(before[-1]) if len(before) else -1
    else:
        after = np.flatnonzero((excess < 0) & (flowing[1] < GRID))
        first = int(after[0]) - 1 if len(after) else -1
    if first < 0:
        return VALVE_DELAY
    share = excess[first] / (excess[first] - excess[first + 1])
    time = float(GRID[first] + share * (GRID[first + 1] - GRID[first]))
    return time if 0.0 < time < MOST else VALVE_DELAY
