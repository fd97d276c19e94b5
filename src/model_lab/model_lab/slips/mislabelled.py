"""Runs that belong to another specimen than the set states, or of a hand to another orientation of
the wrist, one run or two that are exchanged; and two runs whose inputs are exchanged, as where
pressures are logged in files of their own.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import combinations
from typing import Any

import numpy as np

from model_lab.aliases import Array
from model_lab.experiments.forward import Forward
from model_lab.measurements.hands import HAND_POSE, WRIST_POSE
from model_lab.measurements.held_input import DRIVING_COLUMN
from model_lab.measurements.measurement_set import MeasurementSet, Run
from model_lab.measurements.preprocess import thinned
from model_lab.measurements.specimens import made_of
from model_lab.slips.columns import Candidate, one_line
from softhand_common.documents.quoted import listed
from softhand_model.model_file import Model

PREDICTED_SAMPLES = 15  # of a run
MOST_RUNS = 40  # of which any two may have exchanged inputs
MOST_LABELS = 24  # each of which a run may have instead
OF_SPECIMEN, OF_WRIST = "specimen", "wrist_rpy"


@dataclass(frozen=True)
class _Label:
    """What a set states of each run, of which runs may be mistaken: their specimen, or of a hand
    the orientation of the wrist. key: in experiment.yaml. stated (runs,), others: labels, and all
    of them.
    """

    key: str
    column: str
    stated: Sequence[Any]
    others: Sequence[Any]

    def shown(self, label: Any) -> str:
        """A label in words."""
        if self.key == OF_SPECIMEN:
            return str(label)
        return f"{listed(str(round(angle)) for angle in np.degrees(label))} deg"


def mislabelled(data: MeasurementSet, model: Model) -> list[Candidate]:
    """At most two slips for each kind of label: the run that fits another label (specimen, or
    orientation of the wrist) best in place of its own, and the two runs that gain most if theirs
    are exchanged. Only those that lower the error.
    """
    return [slip for label in _labels(data) for slip in _mistaken(data, model, label)]


def _labels(data: MeasurementSet) -> Iterator[_Label]:
    specimens = [run.specimen for run in data.runs]
    yield _Label(OF_SPECIMEN, "specimen", specimens, [s for s in data.specimens if s in specimens])
    held = data.experiment == HAND_POSE and WRIST_POSE[-1] not in data.runs[0].columns
    if held and not data.free_frame:
        turns = [tuple(run.wrist_rpy) for run in data.runs]
        yield _Label(OF_WRIST, "the orientation of the wrist", turns, [*dict.fromkeys(turns)])


def _mistaken(data: MeasurementSet, model: Model, label: _Label) -> list[Candidate]:
    if not 2 <= len(label.others) <= MOST_LABELS:
        return []
    errors = _errors(data, model, label)
    stated = np.array([label.others.index(one) for one in label.stated])
    runs = np.arange(len(stated))
    gain = errors[runs, stated][:, None] - errors
    single = np.unravel_index(int(np.argmax(gain)), gain.shape)
    best = int(single[0]), int(single[1])
    found = [] if gain[best] <= 0.0 else [_stated_anew(data, label, {best[0]: best[1]})]
    pairs = [(i, j) for i, j in combinations(runs.tolist(), 2) if stated[i] != stated[j]]
    gains = [min(gain[i, stated[j]], gain[j, stated[i]]) for i, j in pairs]
    if max(gains, default=0.0) > 0.0:
        i, j = pairs[int(np.argmax(gains))]
        found.append(_stated_anew(data, label, {i: int(stated[j]), j: int(stated[i])}))
    return found


def _errors(data: MeasurementSet, model: Model, label: _Label) -> Array:
    """Sum of squared errors (runs, labels) of each run, had it each label, in the squared unit of
    the outputs; the model is not fitted. Infinite where the model refuses.
    """
    data = thinned(data, 1, PREDICTED_SAMPLES)
    relabelled = (
        replace(data, runs=tuple(replace(run, **{label.key: one}) for run in data.runs))
        for one in label.others
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


def _stated_anew(data: MeasurementSet, label: _Label, anew: Mapping[int, int]) -> Candidate:
    """The set with other labels of some runs: indices of labels by those of runs."""
    names = [data.runs[index].name for index in anew]
    fits = {index: label.others[place] for index, place in anew.items()}
    runs = tuple(
        replace(run, **{label.key: fits.get(index, label.stated[index])})
        for index, run in enumerate(data.runs)
    )
    entries = {
        data.runs[index].name: {label.key: list(one) if label.key == OF_WRIST else one}
        for index, one in fits.items()
    }
    return Candidate(
        "odd_run" if len(names) == 1 else "exchanged",
        f"{label.column} of {' and '.join(names)}",
        " and ".join(label.shown(label.stated[index]) for index in anew),
        " and ".join(map(label.shown, fits.values())),
        one_line({"runs": entries}),
        replace(data, runs=runs),
    )
