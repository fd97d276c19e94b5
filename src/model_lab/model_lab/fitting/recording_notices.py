"""Anomalies of the recordings themselves: inputs, gaps in time, and numbers that seem to be in
another unit.
"""

from __future__ import annotations

import numpy as np

from model_lab.aliases import Array
from model_lab.fitting.noise_floor import NoiseFloor
from model_lab.fitting.notice import NAMED_RUNS, Notice
from model_lab.measurements.held_input import DRIVING_COLUMN, jumps
from model_lab.measurements.limited_input import limit_reached
from model_lab.measurements.measurement_set import MeasurementSet, Run
from model_lab.rules import RULES


def recording_notices(
    data: MeasurementSet, floor: NoiseFloor, residual: Array
) -> list[Notice | None]:
    """Each anomaly of the recordings of a set, or None; residual: of a model (samples,)."""
    return [
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
    ]


def _driven_otherwise(data: MeasurementSet) -> Notice | None:
    """Runs that are stated as repeats, but have another input."""
    found = data.driven_otherwise()
    if not found:
        return None
    pairs = [f"{run} of {first}" for run, first in list(found.items())[:NAMED_RUNS]]
    more = f" and {len(found) - NAMED_RUNS} more" if len(found) > NAMED_RUNS else ""
    pulses = data.experiment == "valve_pulse"
    other = "command other pulses" if pulses else "have another range or pace of the input"
    text = (
        f"runs are stated as repeats but {other}, so that they do not count as such: "
        f"{', '.join(pairs)}{more}"
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
    limit = limit_reached(data, floor.within)
    if limit is None:
        return None
    found, largest = limit.runs, limit.reading
    names = [data.runs[index].name for index in found]
    more = f" and {len(names) - NAMED_RUNS} more" if len(names) > NAMED_RUNS else ""
    size, order = max(found.values()), np.arange(len(data.runs), dtype=float)
    unit = data.shown_in("Pa" if DRIVING_COLUMN[data.experiment] == "pressure" else "")
    text = (
        f"{', '.join(names[:NAMED_RUNS])}{more}: the input stays at its largest reading, "
        f"{unit.shown(largest, 4)}, while the output goes on by {data.output_display.shown(size)} "
        "and comes back, as if its sensor were at the limit; state this `limit` under `columns`, "
        "which leaves these samples out, or use a sensor with a larger range"
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
