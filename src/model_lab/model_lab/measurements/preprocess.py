"""Preprocessing of recordings: long ones are thinned, and noise is removed from recorded inputs.

A search tries some hundred models on every sample; beyond some ten thousand of them the errors of
what it finds come from the few runs there are, not from the noise of samples.

A lag, a play and a viscous branch all average the noise of the pressure that drives them, so a
model with one of them predicts better than one without, though nothing lags. Therefore every sample
of the input is replaced by the middle of a parabola through its neighbours: through as many as the
noise, which is known from fourth differences, allows. Steps, kinks and inputs without noise stay.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from model_lab.aliases import Array
from model_lab.measurements.hands import FOLLOWED, GRASP
from model_lab.measurements.measurement_set import MeasurementSet, Run
from model_lab.rules import RULES

LARGEST_SET = 30000  # samples that are searched
SHORTEST_RUN = 800  # samples that a run keeps
NOISY_COLUMNS = ("pressure", "stretch", "temperature")
WINDOWS = (5, 7, 11, 17, 25)  # samples; the widest that fits is taken
CURVATURE = 2  # order of the polynomials
NORMAL_MEDIAN = 1.4826  # standard deviation of normal values over their median size
FOURTH_DIFFERENCE = np.sqrt(70.0)  # of white noise, over its standard deviation


def thinned(
    data: MeasurementSet, largest: int = LARGEST_SET, shortest: int = SHORTEST_RUN
) -> MeasurementSet:
    """The set with every k-th sample of its longer runs, so that a search takes a minute or two:
    about `largest` samples in all, and at least `shortest` in each run.

    Valve pulses are not thinned, as each one counts, nor are grasps, as a simulation replays each
    completely, nor are motions, which need the whole course of the input; but with `largest` 1, the
    first half of each run is kept.
    """
    samples = sum(run.samples for run in data.runs) * len(data.outputs)
    if samples <= largest or data.experiment in ("valve_pulse", GRASP):
        return data
    if data.experiment in FOLLOWED:
        return _begun(data) if largest == 1 else data
    runs = tuple(_thin(run, samples / largest, shortest) for run in data.runs)
    alike = all(one is run for one, run in zip(runs, data.runs, strict=True))
    return data if alike else replace(data, runs=runs)


def _begun(data: MeasurementSet) -> MeasurementSet:
    """The set with the first half of its runs."""
    runs = (
        replace(run, columns={n: values[: run.samples // 2] for n, values in run.columns.items()})
        for run in data.runs
    )
    return replace(data, runs=tuple(runs))


def _thin(run: Run, wanted: float, shortest: int) -> Run:
    step = max(min(int(wanted + 0.5), run.samples // shortest), 1)
    if step == 1:
        return run
    columns = {name: values[::step] for name, values in run.columns.items()}
    lead = {name: values[::-step][::-1] for name, values in run.lead.items()}
    return replace(run, columns=columns, lead=lead)


def without_input_noise(data: MeasurementSet) -> MeasurementSet:
    """The set with noise removed from its inputs and temperature; unchanged without time."""
    if not data.has_time:
        return data
    return replace(data, runs=tuple(_steadied_run(run) for run in data.runs))


def _steadied_run(run: Run) -> Run:
    columns, lead = dict(run.columns), dict(run.lead)
    for name in NOISY_COLUMNS:
        if name in columns and run.samples >= RULES.input_samples:
            before = lead.get(name, columns[name][:0])
            whole = smoothed(np.concatenate([before, columns[name]]))
            columns[name] = whole[len(before) :]
            if name in lead:
                lead[name] = whole[: len(before)]
    return replace(run, columns=columns, lead=lead)


def noise_of(values: Array) -> float:
    """Standard deviation of white noise on values (n,) of an otherwise smooth course."""
    bends = np.abs(np.diff(values, 4))
    return float(NORMAL_MEDIAN * np.median(bends) / FOURTH_DIFFERENCE)


def smoothed(values: Array) -> Array:
    """Values (n,) without their noise; unchanged if no white noise is seen in them."""
    level, span = noise_of(values), float(np.ptp(values))
    if not RULES.input_quiet * span < level < RULES.input_loud * span or not _is_noise(values):
        return values
    return by_parabolas(values, level)


def by_parabolas(values: Array, level: float) -> Array:
    """Values (n,) without noise of a standard deviation `level`: each is the middle of the widest
    parabola about which its neighbours scatter by that.
    """
    result = values.copy()
    for width in WINDOWS:
        if width > len(values):
            break
        middle, spread = _parabolas(values, width)
        half = width // 2
        fits = spread <= RULES.input_parabola * level
        place = np.arange(half, len(values) - half)[fits]
        result[place] = middle[fits]
    return result


def _is_noise(values: Array) -> bool:
    """Whether fourth differences are those of white noise.

    Neighbours are then correlated by -56/70; those of a smooth course are alike, and those of
    corners that follow closely come again later.
    """
    bends = np.diff(values, 4)
    largest = 4.0 * float(np.median(np.abs(bends)))
    bends = np.clip(bends, -largest, largest)
    power = np.abs(np.fft.rfft(bends, 2 * len(bends))) ** 2
    alike = np.fft.irfft(power)[: len(bends) // 2] / (power.mean() or 1.0)
    later = float(np.max(np.abs(alike[5:]), initial=0.0))
    opposed = alike[1] < RULES.input_opposed * alike[0]
    return bool(opposed and later < RULES.input_alike / np.sqrt(len(bends)))


def _parabolas(values: Array, width: int) -> tuple[Array, Array]:
    """Middle (n - width + 1,) of a parabola through each window, and the spread about it, unbiased
    for white noise.
    """
    place = np.linspace(-1.0, 1.0, width)
    basis = np.linalg.qr(np.vander(place, CURVATURE + 1))[0]
    windows = sliding_window_view(values - values.mean(), width)
    fitted = windows @ basis @ basis.T
    rest = np.sum((windows - fitted) ** 2, axis=1) / (width - CURVATURE - 1)
    return fitted[:, width // 2] + values.mean(), np.sqrt(rest)
