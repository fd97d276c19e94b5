"""Whether two runs were driven alike. Only then do they repeat each other: a model errs differently
on a slow and on a fast ramp, which is no noise.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from scipy.ndimage import median_filter

from model_lab.aliases import Array
from model_lab.rules import RULES

TURN = 0.1  # of the range of an input, from which it is driven, and from which it has turned
SPIKE = 3  # samples, of which the middle one counts if it is the median
DRIVE_SAMPLES = 2000  # of a course, that are looked at
LEVEL_STEP = 0.05  # of the range of an input: step between the levels that are compared
COMPARED_TIMES = 100  # times, at which two courses are compared


@dataclass(frozen=True)
class Drive:
    """The input of a run, such as its pressure.

    extent: largest minus smallest value, in the unit of the input; of an input that is held
    throughout, its level. pace [1/s]: how often the input
    goes through this range, up or down, from the first to the last time at which it exceeds a tenth
    of the range; 0 without a clock. time (k,) [s]: empty without a clock. value (k,): the input
    minus its value at rest.
    """

    extent: float
    pace: float
    time: Array
    value: Array


def drive_of(columns: Mapping[str, Array], lead: Mapping[str, Array], name: str) -> Drive:
    """The input of a run, `name`, with that before its first output.

    >>> time = np.arange(11.0)
    >>> pressure = np.interp(time, [0.0, 4.0, 6.0, 10.0], [0.0, 8.0, 8.0, 0.0])
    >>> found = drive_of({"time": time, "pressure": pressure}, {}, "pressure")
    >>> found.extent, found.pace
    (8.0, 0.2)
    >>> drive_of({"time": time, "pressure": 30.0 + 0.1 * pressure}, {}, "pressure").extent
    30.4
    """
    every = np.concatenate([part[name] for part in (lead, columns) if name in part])
    level = float(np.median(np.abs(every - (1.0 if name == "stretch" else 0.0))))
    step = max(1, len(every) // DRIVE_SAMPLES)
    value = median_filter(every, SPIKE, mode="nearest")[::step]
    value = value - value[0]
    extent = float(np.ptp(value))
    if extent < TURN * level:
        return Drive(level, 0.0, np.zeros(0), value)
    driven = np.flatnonzero(np.abs(value) > TURN * extent)
    if "time" not in columns or not len(driven):
        return Drive(extent, 0.0, np.zeros(0), value)
    time = np.concatenate([part["time"] for part in (lead, columns) if "time" in part])[::step]
    first, last = max(int(driven[0]) - 1, 0), min(int(driven[-1]) + 1, len(value) - 1)
    way = _travelled(value[first : last + 1], TURN * extent)
    pace = way / extent / float(time[last] - time[first])
    return Drive(extent, pace, time, value)


def driven_alike(one: Drive, other: Drive) -> bool:
    """Whether two inputs may be repeats of each other. They may if they have about the same range
    and pace, or would have them in another unit, and go to the same levels one after the other; or
    if they have the same course until one of them ends, as in pulls until rupture.
    """
    return (
        (one.extent > 0.0) == (other.extent > 0.0)
        and _alike(one.extent, other.extent, RULES.repeat_range, RULES.other_unit)
        and _alike(one.pace, other.pace, RULES.repeat_pace, RULES.other_time_unit)
        and _same_levels(one, other)
    ) or _same_course(one, other)


def pulsed_alike(one: Mapping[str, Array], other: Mapping[str, Array]) -> bool:
    """Whether two runs of valve pulses command the same pulses, until one run ends. Otherwise they
    are no repeats: what a model leaves of one pulse is compared with what it leaves of another.

    >>> day = {"direction": np.array([1.0, -1.0]), "duration": np.array([0.1, 0.2])}
    >>> pulsed_alike(day, day), pulsed_alike(day, {**day, "duration": day["duration"][::-1]})
    (True, False)
    """
    first, second = (run["direction"] * run["duration"] for run in (one, other))
    common = min(len(first), len(second))
    size = float(np.mean(np.abs(first[:common])))
    apart = float(np.mean(np.abs(first[:common] - second[:common])))
    return apart <= RULES.repeat_course * size


def _alike(one: float, other: float, most: float, other_unit: float) -> bool:
    low, high = sorted((one, other))
    return not most * low < high < other_unit * low


def _same_levels(one: Drive, other: Drive) -> bool:
    """Whether two inputs go to the same levels in the same order, however fast, until one of them
    ends: their Frechet distance, over their ranges, is at most `repeat_levels`. Without a clock the
    order of levels says nothing.

    The bits of `reached` are the places on the other way up to which both can have gone so far.
    """
    if not len(one.time) or not len(other.time):
        return True
    first, second = _way(one), _way(other)
    reached, last = 1, 1 << (len(second) - 1)
    for at in first:
        near = np.packbits(np.abs(second - at) <= RULES.repeat_levels, bitorder="little")
        free = int.from_bytes(near.tobytes(), "little")
        begun = (reached | reached << 1) & free
        reached = (free & ~(free + begun)) | begun  # and on, as long as places are free
        if not reached:
            return False
        if reached & last:
            return True
    return True


def _way(drive: Drive) -> Array:
    """Values over the range (n,) [-] through which an input goes, one after the other, in steps of
    at most LEVEL_STEP; noise of less than that is left out.
    """
    kept = [0.0]
    for value in (drive.value / drive.extent).tolist() if drive.extent > 0.0 else ():
        if abs(value - kept[-1]) >= LEVEL_STEP:
            kept.append(value)
    legs = np.abs(np.diff(kept))
    along = np.concatenate([[0.0], np.cumsum(legs)])
    return np.interp(np.linspace(0.0, along[-1], int(along[-1] / LEVEL_STEP) + 2), along, kept)


def _same_course(one: Drive, other: Drive) -> bool:
    """Whether two inputs agree from where they begin to where one of them ends."""
    extent = min(one.extent, other.extent)
    if not extent > 0.0 or not len(one.time) or not len(other.time):
        return False
    courses = []
    for drive in (one, other):
        begins = int(np.argmax(np.abs(drive.value) > TURN * extent))
        courses.append((drive.time[begins:] - drive.time[begins], drive.value[begins:]))
    at = np.linspace(0.0, min(float(time[-1]) for time, _ in courses), COMPARED_TIMES)
    first, second = (np.interp(at, *course) for course in courses)
    return bool(np.mean(np.abs(first - second)) <= RULES.repeat_course * extent)


def _travelled(value: Array, least: float) -> float:
    """The way that a course goes up and down, without turns of less than `least`, which are noise.

    >>> _travelled(np.array([0.0, 5.0, 4.9, 8.0, 0.0]), 1.0)
    16.0
    """
    turns = [float(value[0])]
    extreme = turns[0]
    rises = bool(value[int(np.argmax(np.abs(value - value[0]) >= least))] > value[0])
    for now in map(float, value):
        if (now > extreme) == rises:
            extreme = now
        elif abs(now - extreme) >= least:
            turns.append(extreme)
            extreme, rises = now, not rises
    return float(np.sum(np.abs(np.diff([*turns, extreme]))))
