"""Runs that belong to another specimen than the set states, one run or two that are exchanged; and
two runs whose inputs are exchanged, as where pressures are logged in files of their own.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from itertools import combinations

import numpy as np

from model_lab.aliases import Array
from model_lab.experiments.forward import Forward
from model_lab.measurements.held_input import DRIVING_COLUMN
from model_lab.measurements.measurement_set import MeasurementSet, Run
from model_lab.measurements.preprocess import thinned
from model_lab.measurements.specimens import made_of
from model_lab.slips.columns import Candidate, one_line
from softhand_model.model_file import Model

PREDICTED_SAMPLES = 15  # of a run
MOST_RUNS = 40  # of which any two may have exchanged inputs


def mislabelled(data: MeasurementSet, model: Model) -> list[Candidate]:
    """At most two slips: the run that fits another specimen best in place of its own, and the two
    runs that gain most if their specimens are exchanged. Only those that lower the error.
    """
    names = [name for name in data.specimens if any(run.specimen == name for run in data.runs)]
    if len(names) < 2:
        return []
    errors = _errors(data, model, names)
    stated = np.array([names.index(run.specimen) for run in data.runs])
    runs = np.arange(len(stated))
    gain = errors[runs, stated][:, None] - errors
    single = np.unravel_index(int(np.argmax(gain)), gain.shape)
    found = [] if gain[single] <= 0.0 else [_stated_anew(data, {int(single[0]): names[single[1]]})]
    pairs = [(i, j) for i, j in combinations(runs.tolist(), 2) if stated[i] != stated[j]]
    gains = [min(gain[i, stated[j]], gain[j, stated[i]]) for i, j in pairs]
    if max(gains, default=0.0) > 0.0:
        i, j = pairs[int(np.argmax(gains))]
        found.append(_stated_anew(data, {i: names[stated[j]], j: names[stated[i]]}))
    return found


def _errors(data: MeasurementSet, model: Model, names: list[str]) -> Array:
    """Sum of squared errors (runs, specimens) of each run, were it of each specimen, in the squared
    unit of the outputs; the model is not fitted. Infinite where the model refuses.
    """
    data = thinned(data, 1, PREDICTED_SAMPLES)
    relabelled = (
        replace(data, runs=tuple(replace(run, specimen=name) for run in data.runs))
        for name in names
    )
    return np.stack([errors_of_runs(other, model) for other in relabelled], axis=1)


def errors_of_runs(data: MeasurementSet, model: Model) -> Array:
    """Sum of squared errors (runs,) of a model that is not fitted; infinite where it refuses."""
    made = made_of(data, model)
    try:
        forward = Forward(
            made, model.base, (), model.effects, model.calibration, joints=model.springs
        )
    except ValueError:  # such data the model refuses
        return np.full(len(data.runs), np.inf)
    with np.errstate(all="ignore"):
        square = (forward.measured - forward.predict(forward.start()[None])[0]) ** 2
    errors = np.bincount(made.table.run, square, len(data.runs))
    return np.where(np.isfinite(errors), errors, np.inf)


def exchanged_inputs(data: MeasurementSet, model: Model) -> list[Candidate]:
    """The two runs that gain most if each has the input of the other, if the error of both falls:
    one slip at most, and none in sets without time.
    """
    driving = DRIVING_COLUMN.get(data.experiment)
    if driving is None or not data.has_time or len(data.runs) > MOST_RUNS:
        return []
    few = thinned(data, 1, PREDICTED_SAMPLES)
    driven = (
        replace(few, runs=tuple(_driven_as(run, other, driving) for run in few.runs))
        for other in data.runs
    )
    errors = np.stack([errors_of_runs(one, model) for one in driven], axis=1)
    own = np.diag(errors)
    pairs = list(combinations(range(len(own)), 2))
    gains = [min(own[i] - errors[i, j], own[j] - errors[j, i]) for i, j in pairs]
    if not max(gains, default=0.0) > 0.0:
        return []
    i, j = pairs[int(np.argmax(gains))]
    one, other = data.runs[i], data.runs[j]
    runs = list(data.runs)
    runs[i], runs[j] = _driven_as(one, other, driving), _driven_as(other, one, driving)
    return [
        Candidate(
            "exchanged",
            f"the {driving} of {one.name} and {other.name}",
            "their own",
            f"that of {other.name} and {one.name}, exchanged",
            f"runs: exchange the {driving} (the logs) of {one.name} and {other.name}",
            replace(data, runs=tuple(runs)),
        )
    ]


def _driven_as(run: Run, other: Run, driving: str) -> Run:
    """A run with the input of another one, from where both begin."""
    parts = [part for part in (other.lead, other.columns) if driving in part]
    time, value = (np.concatenate([part[name] for part in parts]) for name in ("time", driving))
    columns, lead = (
        {**part, driving: np.interp(part["time"], time, value)} if driving in part else part
        for part in (run.columns, run.lead)
    )
    return replace(run, columns=columns, lead=lead)


def _stated_anew(data: MeasurementSet, specimens: Mapping[int, str]) -> Candidate:
    """The set with other specimens of some runs, by their index."""
    names = [data.runs[index].name for index in specimens]
    runs = tuple(
        replace(run, specimen=specimens.get(index, run.specimen))
        for index, run in enumerate(data.runs)
    )
    entries = {data.runs[index].name: {"specimen": name} for index, name in specimens.items()}
    return Candidate(
        "odd_run" if len(names) == 1 else "exchanged",
        "specimen of " + " and ".join(names),
        " and ".join(data.runs[index].specimen for index in specimens),
        " and ".join(specimens.values()),
        one_line({"runs": entries}),
        replace(data, runs=runs),
    )
