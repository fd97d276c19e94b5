"""Anomalies of a set that do not depend on the model: scatter, a line in the spectrum, wild
samples, a drift, repeats apart, and those of the recordings.

Every difference between repeats raises the noise floor, and so hides errors of the model, even if a
disturbance caused it. Therefore anomalies are reported with every verdict.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.special import gammaincc, stdtr

from model_lab.aliases import Array, IntArray
from model_lab.fitting.noise_floor import REPEATS, NoiseFloor
from model_lab.fitting.notice import NAMED_RUNS, Notice
from model_lab.fitting.recording_notices import recording_notices
from model_lab.measurements.held_input import DRIVING_COLUMN
from model_lab.measurements.measurement_set import MeasurementSet, Run
from model_lab.measurements.preprocess import NORMAL_MEDIAN
from model_lab.rules import RULES

FREQUENCIES = 240  # at which a line is sought
FEWEST_PERIODS = 5.0  # periods in the shortest run
SPECTRUM_SAMPLES = 4000  # samples of a run of which the spectrum is taken
HARMONICS = (1, 2, 3, 4)  # multiples of its frequencies that an input causes in an error
LINE_WIDTH = 3.0  # periods in a run, of one line
COMPARED_RANGE = 3.0  # largest ratio of frequencies whose shares are compared


def notices(data: MeasurementSet, floor: NoiseFloor, residual: Array) -> tuple[Notice, ...]:
    """Anomalies of a set, found in the residual (samples,) of a model and in the recordings."""
    found = (
        _scattered(data, floor),
        _line(data, residual),
        _wild(residual, data),
        _drift(data, floor, residual),
        _apart(data, floor, residual),
        _moved_zero(data, floor, residual),
        *recording_notices(data, floor, residual),
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
    """A frequency at which the error of most runs has a line, though it is no frequency of the
    input, nor a multiple of one.
    """
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
    driven = np.max(
        [
            _shares(t, u, grid / multiple)
            for t, u in zip(times, inputs, strict=True)
            for multiple in HARMONICS
        ],
        axis=0,
    )
    free = driven < RULES.line_in_input
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
