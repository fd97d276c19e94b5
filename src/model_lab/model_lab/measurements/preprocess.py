"""Preprocessing of recordings: long ones thinned, the noise of a recorded input taken off.

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
from model_lab.measurements.measurement_set import MeasurementSet, Run

LARGEST_SET = 30000  # samples that are searched
SHORTEST_RUN = 800  # samples that a run keeps
DRIVING = ("pressure", "stretch")
WINDOWS = (5, 7, 11, 17, 25)  # samples; the widest that fits is taken
CURVATURE = 2  # order of the polynomials
FEWEST = 40  # samples of a run from which its noise is known
NORMAL_MEDIAN = 1.4826  # standard deviation of normal values over their median size
FOURTH_DIFFERENCE = np.sqrt(70.0)  # of white noise, over its standard deviation
LIKELY = 1.35  # root mean square about a parabola over what noise alone would leave
QUIET, LOUD = 1e-5, 0.01  # of the input's range: what is less, or more, is no noise of a sensor
OPPOSED = -0.5  # correlation of neighbouring fourth differences, of which noise has -0.8
ALIKE = 8.0  # autocorrelation of fourth differences, over its error, that noise never has


def thinned(
    data: MeasurementSet, largest: int = LARGEST_SET, shortest: int = SHORTEST_RUN
) -> MeasurementSet:
    """The set with every k-th sample of its longer runs, so that it is searched in a minute or two:
    about `largest` in all, at least `shortest` of each run.

    Pulses, of which each counts, stay as they are.
    """
    samples = sum(run.samples for run in data.runs) * len(data.outputs)
    if samples <= largest or data.experiment == "valve_pulse":
        return data
    wanted = samples / largest
    return replace(data, runs=tuple(_thin(run, wanted, shortest) for run in data.runs))


def _thin(run: Run, wanted: float, shortest: int) -> Run:
    step = max(min(int(wanted + 0.5), run.samples // shortest), 1)
    return replace(run, columns={name: values[::step] for name, values in run.columns.items()})


def without_input_noise(data: MeasurementSet) -> MeasurementSet:
    """The set with the noise of the input taken off, in experiments that an input drives."""
    if not data.has_time:
        return data
    return replace(data, runs=tuple(_steadied_run(run) for run in data.runs))


def _steadied_run(run: Run) -> Run:
    columns = dict(run.columns)
    for name in DRIVING:
        if name in columns and run.samples >= FEWEST:
            columns[name] = smoothed(columns[name])
    return replace(run, columns=columns)


def noise_of(values: Array) -> float:
    """Standard deviation of the white noise on an otherwise smooth course (n,)."""
    bends = np.abs(np.diff(values, 4))
    return float(NORMAL_MEDIAN * np.median(bends) / FOURTH_DIFFERENCE)


def smoothed(values: Array) -> Array:
    """The course (n,) below the noise of values (n,)."""
    level, span = noise_of(values), float(np.ptp(values))
    if not QUIET * span < level < LOUD * span or not _is_noise(values):
        return values
    result = values.copy()
    for width in WINDOWS:
        if width > len(values):
            break
        middle, spread = _parabolas(values, width)
        half = width // 2
        fits = spread <= LIKELY * level
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
    return bool(alike[1] < OPPOSED * alike[0] and later < ALIKE / np.sqrt(len(bends)))


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
