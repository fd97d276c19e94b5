"""Anomalies of a set that do not depend on the model: scatter, a line in the spectrum, wild
samples, a drift, jumps, gaps, and numbers that seem to be in another unit.

Every difference between repeats raises the noise floor, and so hides errors of the model, even if a
disturbance caused it. Therefore anomalies are reported with every verdict.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.special import gammaincc, stdtr

from model_lab.aliases import Array, IntArray
from model_lab.fitting.noise_floor import REPEATS, NoiseFloor
from model_lab.measurements.held_input import DRIVING_COLUMN, jumps
from model_lab.measurements.measurement_set import MeasurementSet, Run
from model_lab.measurements.preprocess import NORMAL_MEDIAN
from model_lab.rules import RULES

FREQUENCIES = 240  # at which a line is sought
FEWEST_PERIODS = 5.0  # periods in the shortest run
SPECTRUM_SAMPLES = 4000  # samples of a run of which the spectrum is taken
LINE_WIDTH = 3.0  # periods in a run, of one line
NAMED_RUNS = 3  # runs or pairs of runs that are named
COMPARED_RANGE = 3.0  # largest ratio of frequencies whose shares are compared


@dataclass(frozen=True)
class Notice:
    """An anomaly of a set.

    kind: `repeats`, `line`, `wild_samples`, `drift`, `apart`, `zero`, `driven`, `held_input`,
    `clipped`, `gaps`, `size`, `absolute`, `duration`, `pulses`, `single_sample` or `left_out`.
    value: by kind, in this order: ratio to the stated noise; frequency [Hz]; number of samples;
    change over the session, largest and rms difference of repeats, all in the SI unit of the
    outputs; number of runs; number of jumps; number of runs; longest gap [s]; ratio to the
    readings; smallest pressure [Pa]; median duration [s]; median of the integrals over
    what is expected; number of runs, for the last two. size: root mean square, or mean of absolute
    values, in the SI unit of the outputs. text: a clause that says it. x, y: the points that show
    it. marked: indices of points that stand out.
    """

    kind: str
    value: float
    size: float
    text: str
    x: Array
    y: Array
    marked: IntArray

    def as_json(self) -> dict[str, Any]:
        """The notice as a dictionary, without the points."""
        return {"kind": self.kind, "value": self.value, "size": self.size, "text": self.text}


def notices(data: MeasurementSet, floor: NoiseFloor, residual: Array) -> tuple[Notice, ...]:
    """Anomalies of a set, found in the residual (samples,) of a model and in the recordings."""
    found = (
        _scattered(data, floor),
        _line(data, residual),
        _wild(residual, data),
        _drift(data, floor, residual),
        _apart(data, floor, residual),
        _moved_zero(data, floor, residual),
        _driven_otherwise(data),
        _held_input(data),
        _clipped(data, floor),
        _gaps(data),
        _size(data, residual),
        _absolute(data),
        _duration(data),
        _pulses(data),
        _single_sample(data),
        _left_out(data),
    )
    return tuple(notice for notice in found if notice is not None)


def _scattered(data: MeasurementSet, floor: NoiseFloor) -> Notice | None:
    """Repeats that differ by far more than the stated noise."""
    stated = [data.noise.get(name) for name in data.outputs]
    if floor.source != REPEATS or any(level is None for level in stated):
        return None
    counts = np.bincount(data.table.output)
    noise = float(np.sqrt(counts @ np.square(np.array(stated, float)) / counts.sum()))
    if not floor.total > RULES.notice_repeats * noise > 0.0:
        return None
    levels = np.array([noise, floor.within, floor.total])
    times = floor.total / noise
    shown = data.output_display.shown(floor.total)
    text = f"repeats scatter by {shown}, {times:.2g} times the stated noise"
    return Notice("repeats", times, floor.total, text, np.arange(3.0), levels, np.array([2]))


# ---------------------------------------------------------------------- a line
def _line(data: MeasurementSet, residual: Array) -> Notice | None:
    """A frequency at which the error of most runs has a line that the input has not."""
    if not data.has_time or data.experiment == "valve_pulse":
        return None
    courses = [c for c in data.table.courses if c.length >= RULES.notice_samples]
    if len(courses) < len(data.table.courses) or not courses:
        return None
    times = [data.runs[c.run].columns["time"][:SPECTRUM_SAMPLES] for c in courses]
    if min(float(np.ptp(time)) for time in times) <= 0.0:
        return None
    grid = _grid(times)
    errors = [residual[c.samples][:SPECTRUM_SAMPLES] for c in courses]
    shares = np.stack([_shares(t, e, grid) for t, e in zip(times, errors, strict=True)])
    inputs = [data.driving(data.runs[c.run])[:SPECTRUM_SAMPLES] for c in courses]
    driven = np.stack([_shares(t, u, grid) for t, u in zip(times, inputs, strict=True)])
    free = np.max(driven, axis=0) < RULES.line_in_input
    many = np.mean(shares >= RULES.line_share, axis=0) >= RULES.line_runs
    mean = shares.mean(axis=0)
    best = int(np.argmax(np.where(free & many, mean, -1.0)))
    if not (free & many)[best] or not _stands_out(mean, grid, best, len(courses)):
        return None
    size = float(np.sqrt(np.mean(residual**2) * mean[best]))
    shown = data.output_display.shown(size)
    text = f"the error of most runs oscillates at {grid[best]:.3g} Hz, {shown} (rms)"
    dying = [_dies_away(*pair) for pair in zip(errors, inputs, strict=True)]
    if np.mean(dying) >= RULES.line_runs:
        text += (
            ", and dies away after a step: the actuator swings, and the model has no inertia; "
            "inflate more slowly, or leave out the samples until it rests"
        )
    return Notice("line", float(grid[best]), size, text, grid, mean, np.array([best]))


def _dies_away(error: Array, driving: Array) -> bool:
    """Whether an error (n,) varies far more just after the largest change of the input (n,) than at
    the end.
    """
    since = error[int(np.argmax(np.abs(np.diff(driving)))) :]
    third = len(since) // 3
    if third < 2:
        return False
    return bool(np.std(since[:third]) > RULES.notice_swing * np.std(since[-third:]))


def _grid(times: Sequence[Array]) -> Array:
    """Frequencies [Hz] from a few periods in the shortest run up to what its samples resolve."""
    low = FEWEST_PERIODS / min(float(np.ptp(time)) for time in times)
    high = 0.4 / max(float(np.median(np.diff(time))) for time in times)
    return np.geomspace(low, max(high, 1.01 * low), FREQUENCIES)


def _shares(time: Array, values: Array, grid: Array) -> Array:
    """Share (frequencies,) of the mean square of values (n,) that a sine of any phase makes up."""
    about = values - values.mean()
    window = np.hanning(len(time))
    rows = np.exp(-2j * np.pi * np.outer(grid, time - time[0]))
    power = np.abs(rows @ (window * about)) ** 2
    total = float(window @ about**2) * float(window.sum())
    return np.asarray(2.0 * power / total if total > 0.0 else 0.0 * power)


def _stands_out(mean: Array, grid: Array, best: int, courses: int) -> bool:
    """Whether the mean share (frequencies,) of some runs exceeds that of others beyond chance.

    The others are not so near that they are of the same line, nor so far that noise differs.
    """
    apart = np.abs(grid - grid[best]) > LINE_WIDTH / FEWEST_PERIODS * grid[0]
    others = mean[apart & (np.abs(np.log(grid / grid[best])) < np.log(COMPARED_RANGE))]
    if not len(others):
        return False
    ratio = float(mean[best]) / max(float(np.median(others)), 1e-300)
    return bool(len(mean) * gammaincc(courses, courses * ratio) < RULES.notice_p_value)


# ---------------------------------------------------------------------- samples and sessions
def _wild(residual: Array, data: MeasurementSet) -> Notice | None:
    """Single samples far from neighbours that agree: those that were replaced, with the errors that
    they had, and others. size: how far.

    Where the input moves as far, over its range, what lies there is the model's error.
    """
    residual, replaced = residual.copy(), _places(data)
    moved = np.array([sample.moved for sample in data.wild])
    np.subtract.at(residual, replaced, moved)
    marked, lies = [replaced], np.zeros(len(residual))
    for course in data.table.courses:
        values = residual[course.samples]
        if data.experiment == "valve_pulse" or len(values) < RULES.notice_samples:
            continue
        steps = np.diff(values)
        level = NORMAL_MEDIAN * float(np.median(np.abs(steps))) / np.sqrt(2.0)
        before, after = steps[:-1], -steps[1:]
        step = _step(data.table.value[course.samples])
        least = max(RULES.notice_wild * level, RULES.notice_steps * step)
        driving = data.driving(data.runs[course.run])
        scale = float(np.ptp(data.table.value[course.samples]) / (np.ptp(driving) or 1.0))
        moves = RULES.notice_slope * scale * np.abs(np.diff(driving))
        least = np.maximum(least, np.maximum(moves[:-1], moves[1:]))
        far = np.minimum(np.abs(before), np.abs(after)) > least
        alone = far & (before * after > 0.0)
        alone &= np.abs(before - after) < 0.5 * np.abs(before + after)
        marked.append(course.start + 1 + np.flatnonzero(alone & (level > 0.0)))
        lies[course.start + 1 : course.stop - 1] = 0.5 * (before + after)
    found = np.unique(np.concatenate(marked)).astype(np.int64)
    if not len(found):
        return None
    order = np.arange(len(residual), dtype=float)
    lies[replaced] = moved
    size = float(np.mean(np.abs(lies[found])))
    many = f"{len(found)} single sample{'s lie' if len(found) > 1 else ' lies'}"
    text = f"{many} far from both neighbouring samples, by {data.output_display.shown(size)}"
    text += (
        f" ({len(np.unique(replaced))} of them are replaced and do not count)"
        if len(replaced)
        else ""
    )
    return Notice("wild_samples", float(len(found)), size, text, order, residual, found)


def _step(readings: Array) -> float:
    """By how much readings (n,) change from one to the next, where they do: a step of the sensor,
    if that is coarse.
    """
    changes = np.abs(np.diff(readings))
    return float(np.median(changes[changes > 0.0])) if changes.any() else 0.0


def _places(data: MeasurementSet) -> IntArray:
    """Places in the table of the readings that were replaced."""
    starts = np.cumsum([0, *(run.samples for run in data.runs)])
    rows = np.array([starts[sample.run] + sample.sample for sample in data.wild], np.int64)
    return np.searchsorted(data.table.row, rows)


def _drift(data: MeasurementSet, floor: NoiseFloor, residual: Array) -> Notice | None:
    """Means of the error that rise or fall from run to run beyond chance."""
    runs = data.table.runs
    if runs < RULES.notice_runs or len(data.outputs) > 1:
        return None
    means = np.bincount(data.table.run, residual) / np.bincount(data.table.run)
    order = np.arange(runs, dtype=float)
    slope, chance = _slope(order, means)
    change = slope * (runs - 1)
    if chance > RULES.notice_p_value or abs(change) < RULES.notice_drift * floor.total:
        return None
    marked = np.zeros(0, np.int64)
    shown = data.output_display.shown(change)
    text = f"the error drifts by {shown} from the first run to the last"
    size = float(np.sqrt(np.mean(means**2)))
    return Notice("drift", change, size, text, order, means, marked)


def _slope(order: Array, means: Array) -> tuple[float, float]:
    """Slope of a straight line through means (n,), and its two-sided p-value (Student's t)."""
    along, off = order - order.mean(), means - means.mean()
    slope = float(along @ off / (along @ along))
    freedom = len(order) - 2
    error = np.sqrt(np.sum((off - slope * along) ** 2) / freedom / (along @ along))
    if error == 0.0:
        return slope, float(slope == 0.0)
    return slope, 2.0 * float(stdtr(freedom, -abs(slope) / error))


def _apart(data: MeasurementSet, floor: NoiseFloor, residual: Array) -> Notice | None:
    """Repeats whose mean errors differ by many noise floors: the floor follows most of them."""
    if floor.source != REPEATS or len(data.outputs) > 1:
        return None
    means = np.bincount(data.table.run, residual) / np.bincount(data.table.run)
    found = []
    for group in data.groups():
        low, *_, high = sorted(group, key=lambda run: means[run]) if len(group) > 1 else (0, 0)
        found.append((float(means[high] - means[low]), low, high))
    least = RULES.notice_apart * floor.total
    far = sorted((one for one in found if one[0] > least), reverse=True)
    if not far:
        return None
    shown = data.output_display.shown
    pairs = [
        f"{data.runs[high].name} lies {shown(apart)} above {data.runs[low].name}"
        for apart, low, high in far[:NAMED_RUNS]
    ]
    more = f" and {len(far[NAMED_RUNS:])} more" if far[NAMED_RUNS:] else ""
    text = f"runs that repeat each other have different mean errors: {', '.join(pairs)}{more}"
    size = float(np.sqrt(np.mean(means**2)))
    order = np.arange(len(means), dtype=float)
    marked = np.array(sorted({run for _, *pair in far for run in pair}), np.int64)
    return Notice("apart", far[0][0], size, text, order, means, marked)


def _moved_zero(data: MeasurementSet, floor: NoiseFloor, residual: Array) -> Notice | None:
    """Repeats that differ at rest as much as they do in the whole: by their zero."""
    if floor.source != REPEATS or len(data.outputs) > 1 or data.experiment not in DRIVING_COLUMN:
        return None
    means = np.bincount(data.table.run, residual) / np.bincount(data.table.run)
    at_rest = np.array([_at_rest(data, run) for run in data.runs])
    before, after = (_apart_in_groups(data, one) for one in (means, means - at_rest))
    if not (before > RULES.notice_zero * floor.within and after < RULES.notice_zero_left * before):
        return None
    shown = data.output_display.shown
    text = (
        f"repeats differ by their zero, {shown(before)} (rms), already at rest: take the reading "
        "at rest off each run, or the noise floor, which includes this, hides what is missing"
    )
    order, marked = np.arange(len(means), dtype=float), np.zeros(0, np.int64)
    return Notice("zero", before, before, text, order, at_rest, marked)


def _at_rest(data: MeasurementSet, run: Run) -> float:
    """Median output of a run at inputs near its least."""
    driving = data.driving(run)
    rests = driving <= driving.min() + RULES.pressure_ends * np.ptp(driving)
    return float(np.median(run.columns[data.outputs[0]][rests]))


def _apart_in_groups(data: MeasurementSet, values: Array) -> float:
    """Root mean square difference of values (runs,) from the mean of their repeats."""
    off = np.concatenate([values[group] - values[group].mean() for group in data.groups()])
    return float(np.sqrt(np.mean(off**2)))


def _driven_otherwise(data: MeasurementSet) -> Notice | None:
    """Runs that are stated as repeats, but have another input."""
    found = data.driven_otherwise()
    if not found:
        return None
    pairs = [f"{run} of {first}" for run, first in list(found.items())[:NAMED_RUNS]]
    more = f" and {len(found) - NAMED_RUNS} more" if len(found) > NAMED_RUNS else ""
    text = (
        f"runs are stated as repeats but have another range or pace of the input, so that they do "
        f"not count as such: {', '.join(pairs)}{more}"
    )
    order = np.arange(len(data.runs), dtype=float)
    ranges = np.array([np.ptp(data.driving(run)) for run in data.runs])
    marked = np.flatnonzero([run.name in found for run in data.runs])
    return Notice("driven", float(len(found)), 0.0, text, order, ranges, marked)


def _held_input(data: MeasurementSet) -> Notice | None:
    """An input that is held between samples where it jumps: time constants depend on that."""
    if not data.jumps:
        return None
    places = [jumps(data, run) for run in data.runs]
    run, marked = max(zip(data.runs, places, strict=True), key=lambda pair: len(pair[1]))
    text = (
        "the input is taken as constant between its jumps, as held-out data are then predicted "
        "better"
    )
    count = float(sum(map(len, places)))
    x, y = run.columns["time"], data.driving(run) / float(np.max(np.abs(data.driving(run))))
    return Notice("held_input", count, 0.0, text, x, y, marked)


def _clipped(data: MeasurementSet, floor: NoiseFloor) -> Notice | None:
    """An input that stays at its largest reading while the output goes on and comes back."""
    if not data.has_time or data.experiment not in DRIVING_COLUMN or len(data.outputs) > 1:
        return None
    largest = max(float(np.max(data.driving(run))) for run in data.runs)
    found = {}
    for index, run in enumerate(data.runs):
        at = np.flatnonzero(data.driving(run) >= (1.0 - RULES.notice_clip_within) * largest)
        if not len(at) or len(at) < max(
            RULES.notice_clipped, RULES.notice_clip_share * (at[-1] - at[0])
        ):
            continue
        output = run.columns[data.outputs[0]][at[0] : at[-1] + 1]
        ends = np.linspace(output[0], output[-1], len(output))
        goes_on = float(np.max(np.abs(output - ends)))
        comes_back = abs(output[-1] - output[0]) < RULES.notice_clip_back * goes_on
        if comes_back and goes_on > RULES.notice_wild * floor.within:
            found[index] = goes_on
    if not found:
        return None
    names = [data.runs[index].name for index in found]
    more = f" and {len(names) - NAMED_RUNS} more" if len(names) > NAMED_RUNS else ""
    size, order = max(found.values()), np.arange(len(data.runs), dtype=float)
    unit = data.shown_in("Pa" if DRIVING_COLUMN[data.experiment] == "pressure" else "")
    text = (
        f"{', '.join(names[:NAMED_RUNS])}{more}: the input stays at its largest reading, "
        f"{unit.shown(largest, 4)}, while the output goes on by {data.output_display.shown(size)} "
        "and comes back, as if its sensor were at the limit; leave these samples out, or use a "
        "sensor with a larger range"
    )
    ranges = np.array([found.get(index, 0.0) for index in range(len(data.runs))])
    marked = np.array([*found], np.int64)
    return Notice("clipped", float(len(found)), size, text, order, ranges, marked)


def _gaps(data: MeasurementSet) -> Notice | None:
    """Gaps in the time column, over which what the input did is not known."""
    if not data.has_time or data.experiment == "valve_pulse":
        return None
    long = [run for run in data.runs if run.samples >= RULES.notice_samples]
    steps = [np.diff(run.columns["time"]) for run in long]
    gaps = [np.flatnonzero(step > RULES.time_gap * float(np.median(step))) for step in steps]
    count = sum(map(len, gaps))
    if not count:
        return None
    found, marked = max(zip(steps, gaps, strict=True), key=lambda pair: len(pair[1]))
    longest = max(float(step[at].max()) for step, at in zip(steps, gaps, strict=True) if len(at))
    text = (
        f"the time column has {count} gap{'s' if count > 1 else ''} of up to {longest:.2g} s: "
        "effects with memory are computed as if the input were interpolated linearly, so time "
        "constants are less certain than their errors say"
    )
    return Notice("gaps", longest, 0.0, text, np.arange(len(found), dtype=float), found, marked)


# ---------------------------------------------------------------------- units
def _size(data: MeasurementSet, residual: Array) -> Notice | None:
    """Values of the model that are far larger or smaller than the readings, as wrong units make."""
    read = float(np.sqrt(np.mean(data.table.value**2)))
    said = float(np.sqrt(np.mean((data.table.value - residual) ** 2)))
    if not max(read, said) > RULES.notice_size * min(read, said):
        return None
    shown = data.output_display.shown
    text = (
        f"the model says {shown(said)} where {shown(read)} are read (rms): check the units in "
        "`columns`, and the sizes and the modulus of the specimens"
    )
    order, marked = np.arange(len(residual), dtype=float), np.zeros(0, np.int64)
    return Notice("size", said / max(read, 1e-300), said, text, order, residual, marked)


def _absolute(data: MeasurementSet) -> Notice | None:
    """Pressures that never fall below about that of the air, though the actuator is at rest."""
    if not seem_absolute(data):
        return None
    least = _least_pressures(data)
    shown = data.shown_in("Pa").shown(float(least.min()), 4)
    text = (
        f"no pressure is below {shown}, at which the actuator rests: expected "
        "is gauge pressure, 0 at rest; take that of the air off if these are absolute"
    )
    order, marked = np.arange(len(least), dtype=float), np.zeros(0, np.int64)
    return Notice("absolute", float(least.min()), 0.0, text, order, least, marked)


def seem_absolute(data: MeasurementSet) -> bool:
    """Whether no pressure of any run is below about that of the air, though the actuator rests."""
    if data.experiment == "valve_pulse" or any("pressure" not in r.columns for r in data.runs):
        return False
    least, (low, high) = _least_pressures(data), RULES.atmosphere
    return bool(low < least.min() and least.max() < high) and _rests(data)


def _least_pressures(data: MeasurementSet) -> Array:
    """The least pressure [Pa] of each run (runs,)."""
    return np.array([float(run.columns["pressure"].min()) for run in data.runs])


def _rests(data: MeasurementSet) -> bool:
    """Whether the output at the least pressures is so small beside that at the largest that these
    cannot be gauge pressures: of rubber it grows at most four times as fast as they do.
    """
    pressure = np.concatenate([run.columns["pressure"] for run in data.runs])
    measured = np.concatenate(
        [[r.columns[name] for name in data.outputs] for r in data.runs], axis=1
    )
    size = np.linalg.norm(measured, axis=0)
    low, high = float(pressure.min()), float(pressure.max())
    near = RULES.pressure_ends * (high - low)
    first, last = size[pressure <= low + near], size[pressure >= high - near]
    return bool(np.nanmean(first) * RULES.softest < np.nanmean(last) * low / high)


# ---------------------------------------------------------------------- times
def _duration(data: MeasurementSet) -> Notice | None:
    """Runs that last as long, or as short, as those of an actuator do in another unit of time."""
    lasting = [float(np.ptp(r.columns["time"])) for r in data.runs if r.samples > 1 and _timed(r)]
    usual = float(np.median(lasting)) if lasting else RULES.durations[0]
    if RULES.durations[0] <= usual <= RULES.durations[1]:
        return None
    unit = "milliseconds" if usual > RULES.durations[1] else "seconds"
    text = (
        f"a run lasts {usual:.3g} s (median): if the times are {unit}, write that unit for the "
        "column time; time constants and rates depend on it"
    )
    order, marked = np.arange(len(lasting), dtype=float), np.zeros(0, np.int64)
    return Notice("duration", usual, 0.0, text, order, np.array(lasting), marked)


def _pulses(data: MeasurementSet) -> Notice | None:
    """Pulses whose integral of p_in - p_out is not about the duration times what it was first."""
    if data.experiment != "valve_pulse":
        return None
    shares = pulse_shares(data)
    share = float(np.median(shares)) if len(shares) else 1.0
    low, high = RULES.pulse_shares
    if low <= share <= high:
        return None
    text = (
        f"friction_integral is {share:.3g} times (p_in - p_out)*duration (median), expected "
        f"{low:g} to {high:g}: look at the units of duration and of the integrals"
    )
    order, marked = np.arange(len(shares), dtype=float), np.zeros(0, np.int64)
    return Notice("pulses", share, 0.0, text, order, shares, marked)


def pulse_shares(data: MeasurementSet) -> Array:
    """Integrals of p_in - p_out over its first value and the duration, of the pulses (n,) that have
    a pressure drop and of which the integral was recorded.
    """
    needed = ("friction_integral", "p_in", "p_out", "duration")
    runs = [run.columns for run in data.runs if all(name in run.columns for name in needed)]
    if not runs:
        return np.zeros(0)
    integral, before, after, lasting = (np.concatenate([r[name] for r in runs]) for name in needed)
    flows = before > after
    return integral[flows] / ((before - after) * lasting)[flows]


def _timed(run: Run) -> bool:
    return "time" in run.columns


def _single_sample(data: MeasurementSet) -> Notice | None:
    """Runs of a single sample, though others have a course, or a time was recorded."""
    samples = np.array([run.samples for run in data.runs])
    marked = np.flatnonzero(samples == 1)
    if data.experiment == "valve_pulse" or not len(marked):
        return None
    if samples.max() == 1 and not data.has_time:
        return None
    names = ", ".join(data.runs[index].name for index in marked[:NAMED_RUNS])
    more = f" and {len(marked[NAMED_RUNS:])} more" if len(marked[NAMED_RUNS:]) else ""
    text = f"only a single sample was recorded of {names}{more}, as in a truncated recording"
    order = np.arange(len(samples), dtype=float)
    return Notice("single_sample", float(len(marked)), 0.0, text, order, 1.0 * samples, marked)


def _left_out(data: MeasurementSet) -> Notice | None:
    """Runs that the model cannot follow, beside those that it can."""
    if not data.left_out:
        return None
    whole = [f"{name}, in which {reason}" for name, reason in data.left_out.items()]
    said, rest = "; ".join(whole[:NAMED_RUNS]), whole[NAMED_RUNS:]
    more = f"; and {len(rest)} more" if rest else ""
    kept, gone = len(data.runs), len(data.left_out)
    follows = np.repeat([1.0, 0.0], [kept, gone])
    order = np.arange(kept + gone, dtype=float)
    marked = np.arange(kept, kept + gone)
    text = f"left out, as the model cannot follow them: {said}{more}"
    return Notice("left_out", float(gone), 0.0, text, order, follows, marked)
