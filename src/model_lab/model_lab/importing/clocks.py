"""Times of day, stop-watch times and dates in text form, in seconds."""

from __future__ import annotations

import datetime
import re
from collections.abc import Sequence

import numpy as np

from model_lab.aliases import Array, Indices
from model_lab.importing.numerals import is_missing

_CLOCK = (
    r"(?:(?P<first>\d+):)?(?P<middle>\d{1,2}):(?P<last>\d{1,2}(?:[.,]\d+)?)"
    r"(?:(?<=:\d\d):(?P<parts>\d{2}))?"
)
_HALF = r"(?:\s*(?P<half>[AaPp])\.?\s?[Mm]\.?)?"
_ZONE = r"\s*(?P<zone>Z|UTC|[+-]\d{2}:?\d{2})?"
_DAY_PATTERN = r"(?P<a>\d{1,4})[-./](?P<b>\d{1,2})[-./](?P<c>\d{1,4})(?:T|\s+|,\s*)"
_TEXT = re.compile(f"(?:{_DAY_PATTERN})?{_CLOCK}{_HALF}{_ZONE}$")
HOUR, HALF_DAY, DAY = 3600.0, 43200.0, 86400.0  # [s]
RESTART_STEPS = 5.0  # usual steps of a clock, by more than which it goes back, by hand
PAUSE_STEPS = 50.0  # usual steps of a clock, from which a longer one is a pause, by hand
ORDERS = ("day first", "month first")


def is_time(cell: str) -> bool:
    """Whether a cell holds a time of day, a stop watch's time, or a date with a time.

    >>> is_time("27:19.12"), is_time("2026-03-01T12:27:19Z"), is_time("3/1/2026 1:02:03 PM")
    (True, True, True)
    """
    return ":" in cell and _TEXT.match(cell) is not None


def may_be_hours(cells: Sequence[str]) -> bool:
    """Whether all times are like 12:27, which may be hours and minutes as well as minutes and
    seconds.
    """
    found = [match for match in map(_TEXT.match, cells) if match is not None]
    return all(
        match["first"] is None
        and match["a"] is None
        and match["last"].isdecimal()
        and int(match["middle"]) < 24
        for match in found
    )


def seconds(cells: Sequence[str]) -> Array:
    """Seconds (rows,) of times of day, stop-watch times or dates; NaN for a cell without one.

    Two parts, as in 12:27, are minutes and seconds. A clock that jumps back is taken to go on:
    after one hour if it shows minutes and seconds, else after half a day or a day. For dates such
    as 3/1/2026, day and month are ordered so that the whole takes less time. A fourth part, as in
    0:00:12:08 of a video, counts hundredths of a second or frames.
    """
    found = [None if is_missing(cell) else _TEXT.match(cell) for cell in cells]
    clock = np.array([np.nan if one is None else _of_day(one) for one in found])
    clock += _parts(clock, np.array([float(one["parts"] or 0) if one else 0.0 for one in found]))
    if any(one is not None and one["a"] for one in found):
        days = [_days(found, order) for order in ORDERS]
        return clock + min((one for one in days if one is not None), key=_span) * DAY
    short = all(one is None or one["first"] is None for one in found)
    return _going_on(clock, (HOUR,) if short else (HALF_DAY, DAY))


def is_newest_first(time: Array) -> bool:
    """Whether times (rows,) fall from the first to the last row."""
    steps = np.diff(time)
    return len(steps) > 1 and bool(np.all(steps <= 0.0)) and bool(np.any(steps < 0.0))


def spread(time: Array) -> Array:
    """Times (rows,) in which rows that share a stamp are spaced evenly up to the next stamp; rows
    with the last stamp are spaced by the median step. Times that fall somewhere, or are all the
    same, are returned as they are.

    >>> spread(np.array([0.0, 0.0, 1.0, 1.0, 2.0]))
    array([0. , 0.5, 1. , 1.5, 2. ])
    """
    if np.any(np.diff(time) < 0.0) or len(time) < 2 or time[0] == time[-1]:
        return time
    stamps, counts = np.unique(time, return_counts=True)
    steps = np.diff(stamps) / counts[:-1]
    steps = np.append(steps, np.median(steps))
    within = np.arange(len(time)) - np.repeat(np.cumsum(counts) - counts, counts)
    return np.repeat(stamps, counts) + within * np.repeat(steps, counts)


def restarts(time: Array) -> Indices:
    """Indices (n,) of the rows at which a clock (rows,) [s] begins anew: it goes back to where it
    began, or to before.

    >>> restarts(np.array([*range(9), *range(9)])).tolist(), restarts(np.arange(9.0)).tolist()
    ([9], [])
    """
    if len(time) < 2 or is_newest_first(time):
        return np.zeros(0, np.intp)
    steps = np.diff(time)
    usual = float(np.median(steps[steps > 0.0])) if np.any(steps > 0.0) else 0.0
    short = RESTART_STEPS * usual
    begins = (steps < -short) & (time[1:] <= time[0] + short)
    return np.flatnonzero(begins) + 1


def pauses(time: Array) -> Indices:
    """Indices (n,) of the rows at which a clock (rows,) goes on after a pause.

    >>> pauses(np.array([*range(9), *range(99, 108)])).tolist(), pauses(np.arange(9.0)).tolist()
    ([9], [])
    """
    steps = np.diff(time)
    usual = float(np.median(steps)) if len(steps) else 0.0
    return 1 + np.flatnonzero(steps > PAUSE_STEPS * usual) if usual > 0.0 else np.zeros(0, np.intp)


def _span(days: Array) -> float:
    return float(np.nanmax(days) - np.nanmin(days))


def _of_day(match: re.Match[str]) -> float:
    """Seconds of a time since the day began, or the stop watch."""
    parts = (match["middle"], match["last"].replace(",", "."))
    hours = float(match["first"] or 0)
    if match["half"]:
        if match["first"] is None:  # hours and minutes
            parts, hours = (match["last"], "0"), float(match["middle"])
        hours = hours % 12.0 + (12.0 if match["half"] in "Pp" else 0.0)
    since = HOUR * hours + 60.0 * float(parts[0]) + float(parts[1])
    zone = match["zone"]
    if zone and zone[0] in "+-":
        away = HOUR * float(zone[1:3]) + 60.0 * float(zone[-2:])
        since -= away if zone[0] == "+" else -away
    return since


def _parts(whole: Array, parts: Array) -> Array:
    """Seconds (rows,) of counts (rows,) of hundredths or of frames after whole seconds (rows,): of
    a second's most frames, if the clock then goes on more evenly.
    """
    units = [part * parts for part in (0.01, 1.0 / (float(parts.max(initial=0.0)) + 1.0))]
    return min(units, key=lambda one: _unevenness(whole + one))


def _unevenness(time: Array) -> float:
    steps = np.diff(time[np.isfinite(time)])
    return float(np.std(steps)) if len(steps) else 0.0


def _days(found: Sequence[re.Match[str] | None], order: str) -> Array | None:
    """Number (rows,) of the day of each date; None where they are none in this order."""
    try:
        return np.array([np.nan if one is None else _day(one, order) for one in found])
    except ValueError:
        return None


def _day(match: re.Match[str], order: str) -> float:
    if match["a"] is None:
        raise ValueError("expected a date in every row")
    a, b, c = (int(match[name]) for name in "abc")
    if len(match["a"]) == 4:
        year, month, day = a, b, c
    else:
        year = c + 2000 if c < 100 else c
        day, month = (a, b) if order == ORDERS[0] else (b, a)
    return float(datetime.date(year, month, day).toordinal())


def _going_on(clock: Array, periods: Sequence[float]) -> Array:
    """A clock (rows,) without the jumps back where it begins anew."""
    known = np.flatnonzero(np.isfinite(clock))
    steps = np.diff(clock[known])
    added = np.zeros(len(steps))
    for period in periods:
        begins = (added == 0.0) & (steps < -0.5 * period) & (steps >= -period)
        added[begins] = period
    result = clock.copy()
    result[known[1:]] += np.cumsum(added)
    return result
