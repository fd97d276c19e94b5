"""The next experiment: the one in which the effects still tied differ most, in units of noise.

Two explanations that fit equally well still differ where nothing was measured. Over a bank of
protocols, at temperatures and mounts of choice, the separation of a pair is

    d**2 = D' (C + J1 S1 J1' + J2 S2 J2')**-1 D,

with the difference D of their predictions, the noise C of a run, and what each explanation may
still give way, its Jacobian J and the covariance S of its parameters. The experiment whose worst
pair is furthest apart is proposed.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import combinations
from typing import Any

import numpy as np
from numpy.typing import NDArray

from model_lab.fit import DIFFERENCE
from model_lab.measurement import MeasurementSet, Run
from model_lab.protocols import BANK, Protocol
from model_lab.rivals import driving_input
from model_lab.search import Question, Scored
from model_lab.series import series_of
from model_lab.spectrum import make_spectrum

Array = NDArray[np.float64]

SAMPLES = 200
DURATIONS = (0.25, 1.0, 4.0)  # of the longest run so far
TEMPERATURE_STEPS = (0.0, 20.0)  # [K]
MOUNTS = ("bending_plane_level", "base_up", "base_down")
MEMORY_RUN = "planned"


@dataclass(frozen=True)
class Experiment:
    """A proposed run; separation: of the worst tied pair in units of noise."""

    protocol: Protocol
    duration: float
    peak: float
    temperature: float
    mount: str
    specimen: str
    separation: float

    def as_json(self, driving: str) -> dict[str, Any]:
        """What the diagnosis and `plan --json` say of it; time [s], input in SI units."""
        time, course = self.protocol.course(self.duration, self.peak, SAMPLES)
        return {
            "protocol": self.protocol.name,
            "description": self.protocol.description,
            "specimen": self.specimen,
            "mount": self.mount,
            "temperature": self.temperature,
            "duration": self.duration,
            "peak": self.peak,
            "separation": self.separation,
            "time": time.tolist(),
            driving: course.tolist(),
        }


def next_experiment(question: Question, tied: Sequence[Scored]) -> Experiment | None:
    """The experiment that separates these explanations best; None for fewer than two of them."""
    if len(tied) < 2 or question.data.experiment in ("valve_pulse", "base_torque"):
        return None
    return max(
        (replace(trial, separation=_worst(question, tied, trial)) for trial in _trials(question)),
        key=lambda trial: trial.separation,
    )


def _trials(question: Question) -> list[Experiment]:
    """Experiments within the pressures and rates that the set has seen."""
    data = question.data
    inputs = [driving_input(run, data.experiment) for run in data.runs]
    rest = 1.0 if data.experiment == "uniaxial" else 0.0
    peak = max(float(values.max()) for values in inputs) - rest
    longest, fastest = _longest(data), _fastest(data, inputs)
    specimen = next(iter(data.specimens.values()))
    mounts = MOUNTS if "mass" in specimen.values else (specimen.mount,)
    return [
        Experiment(entry, share * longest, peak, 293.15 + warmer, mount, specimen.name, 0.0)
        for entry in BANK
        for share in DURATIONS
        for warmer in TEMPERATURE_STEPS
        for mount in (mounts if data.experiment == "free_bending" else (specimen.mount,))
        if entry.fastest() * peak / (share * longest) <= 1.01 * fastest
    ]


def _longest(data: MeasurementSet) -> float:
    """Duration [s] of the longest run; without time that of a slow manual one."""
    if not data.has_time:
        return 20.0
    return max(float(np.ptp(run.columns["time"])) for run in data.runs)


def _fastest(data: MeasurementSet, inputs: Sequence[Array]) -> float:
    """Largest rate of the input over a fiftieth of the longest run."""
    if not data.has_time:
        return np.inf
    window = _longest(data) / 50.0
    rates = []
    for run, values in zip(data.runs, inputs, strict=True):
        time = run.columns["time"]
        later = np.interp(time + window, time, values)
        rates.append(float(np.max(np.abs(later - values))) / window)
    # a step counts as one within the window: what can be stepped can be stepped again
    return max(2.0 * max(rates), 1e-9)


def _worst(question: Question, tied: Sequence[Scored], trial: Experiment) -> float:
    predictions = [_predicted(question, scored, trial) for scored in tied]
    pairs = combinations(range(len(tied)), 2)
    return min(_separation(question, predictions[a], predictions[b]) for a, b in pairs)


@dataclass(frozen=True)
class _Prediction:
    values: Array
    spread: Array  # (samples, k): Jacobian times the root of the covariance


def _predicted(question: Question, scored: Scored, trial: Experiment) -> _Prediction:
    """What a fitted model predicts for a trial, after the runs that have been made."""
    planned = _planned_set(question.data, trial)
    forward = replace(question, data=planned).problem(scored.effects).forward
    fit = scored.fit
    scales = fit.problem.scales
    center = scales.inward(fit.values)
    lanes = np.vstack([center, center + np.diag(DIFFERENCE * scales.width)])
    predicted = forward.predict(scales.outward(lanes))[:, -SAMPLES:]
    jacobian = ((predicted[1:] - predicted[:1]) / (DIFFERENCE * scales.width)[:, None]).T
    level, vectors = np.linalg.eigh(fit.covariance)
    return _Prediction(predicted[0], jacobian @ (vectors * np.sqrt(np.maximum(level, 0.0))))


def _planned_set(data: MeasurementSet, trial: Experiment) -> MeasurementSet:
    """The set with the planned run as its last: what has been stretched stays stretched."""
    time, course = trial.protocol.course(trial.duration, trial.peak, SAMPLES)
    driving = "stretch" if data.experiment == "uniaxial" else "pressure"
    rest = 1.0 if data.experiment == "uniaxial" else 0.0
    columns = {"time": time, driving: rest + course, data.outputs[0]: np.zeros(SAMPLES)}
    specimen = replace(data.specimens[trial.specimen], name=MEMORY_RUN, mount=trial.mount)
    same = trial.mount == data.specimens[trial.specimen].mount
    name = trial.specimen if same else MEMORY_RUN
    run = Run(MEMORY_RUN, name, MEMORY_RUN, trial.temperature, columns)
    # only runs of the same specimen leave a trace in the planned one
    earlier = tuple(r for r in data.runs if r.specimen == name and data.has_time)
    specimens = {**data.specimens, **({} if same else {MEMORY_RUN: specimen})}
    return replace(data, runs=(*earlier, run), specimens=specimens)


def _separation(question: Question, first: _Prediction, second: _Prediction) -> float:
    """Separation d of two predictions of one run."""
    difference = first.values - second.values
    run = Run(MEMORY_RUN, MEMORY_RUN, MEMORY_RUN, 293.15, {"x": difference})
    alone = replace(question.data, runs=(run,), experiment=question.data.experiment)
    spectrum = make_spectrum(
        series_of(replace(alone, runs=(run, replace(run, protocol="b")))), np.tile(first.values, 2)
    )
    rows = np.vstack([difference, first.spread.T, second.spread.T])
    coefficients = spectrum.coefficients(np.hstack([rows, rows]))[:, : len(difference)]
    levels = _levels(question, spectrum.bands[: len(difference)])
    whitened = coefficients / np.sqrt(levels)
    target, give = whitened[0], whitened[1:]
    inner = np.eye(len(give)) + give @ give.T
    taken = give @ target
    square = target @ target - taken @ np.linalg.solve(inner, taken)
    return float(np.sqrt(max(square, 0.0)))


def _levels(question: Question, bands: NDArray[np.int64]) -> Array:
    """Noise variance of each coefficient of a new run; bands not seen are like the finest."""
    known = question.floor.variance
    return known[np.minimum(bands, len(known) - 1)]
