"""Runs that belong to another specimen than the set states: one run, or two that are exchanged."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from itertools import combinations

import numpy as np

from model_lab.aliases import Array
from model_lab.experiments.forward import Forward
from model_lab.measurements.measurement_set import MeasurementSet
from model_lab.measurements.preprocess import thinned
from model_lab.measurements.specimens import made_of
from model_lab.slips.columns import Candidate, one_line
from softhand_model.model_file import Model

PREDICTED_SAMPLES = 15  # of a run


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
    errors = np.full((len(data.runs), len(names)), np.inf)
    for column, name in enumerate(names):
        relabelled = replace(data, runs=tuple(replace(run, specimen=name) for run in data.runs))
        made = made_of(relabelled, model)
        try:
            forward = Forward(
                made, model.base, (), model.effects, model.calibration, joints=model.springs
            )
        except ValueError:  # such data the model refuses
            continue
        with np.errstate(all="ignore"):
            square = (forward.measured - forward.predict(forward.start()[None])[0]) ** 2
        errors[:, column] = np.bincount(made.table.run, square, len(data.runs))
    return np.where(np.isfinite(errors), errors, np.inf)


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
