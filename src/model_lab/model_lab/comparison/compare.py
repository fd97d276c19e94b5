"""Comparison of a model with a measurement set: how large the error is, and where it lies."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from model_lab.aliases import Array, IntArray, Tell, tell_nobody
from model_lab.diagnosis.result import calibration_at_bound, calibration_of
from model_lab.diagnosis.search import Scored, score_base
from model_lab.experiments.forward import Forward
from model_lab.fitting.noise_floor import NoiseFloor
from model_lab.fitting.notice import Notice
from model_lab.fitting.notices import notices
from model_lab.fitting.problem import pose_problem
from model_lab.localisation.input_relation import InputRelation, input_relation
from model_lab.localisation.localise import Localisation, localise
from model_lab.measurements.measurement_set import MeasurementSet
from model_lab.measurements.sample_table import SampleTable
from model_lab.series.events import NO_SERIES, Event, Series
from model_lab.series.lowering import examine_lowering
from model_lab.series.mended import without_events
from model_lab.series.within_runs import WithinRuns, residual_tests
from model_lab.slips.find import find_slips, score
from model_lab.slips.outside import outside
from model_lab.slips.slip import Slip
from softhand_model.model_file import Model

PROGRESS_STEPS = 3  # of the progress of a comparison


@dataclass(frozen=True)
class Accuracy:
    """Accuracy of predictions over some samples; errors are measured minus predicted, in the SI
    unit of the outputs.

    rmse: root mean square error. fit: 100*(1 - |y - yhat|/|y - mean y|) [percent], with the mean of
    each output; NaN if no output varies. bias: mean error. largest: largest absolute error.
    """

    samples: int
    rmse: float
    fit: float
    bias: float
    largest: float


def accuracy(measured: Array, residual: Array, output: IntArray) -> Accuracy:
    """Accuracy of predictions, from measured values, residuals (measured minus predicted) and the
    number of the output, each (samples,).
    """
    mean = _means(measured, output)[output]
    spread = float(np.linalg.norm(measured - mean))
    stands = np.allclose(measured, mean, rtol=1e-9, atol=0.0)  # but for rounding
    size = float(np.linalg.norm(residual))
    return Accuracy(
        len(residual),
        size / float(np.sqrt(len(residual))),
        float("nan") if stands else 100.0 * (1.0 - size / spread),
        float(residual.mean()),
        float(np.abs(residual).max()),
    )


def _means(values: Array, output: IntArray) -> Array:
    """Mean of each output."""
    return np.asarray(np.bincount(output, values) / np.maximum(np.bincount(output), 1), float)


@dataclass(frozen=True)
class Errors:
    """Errors of a model on a measurement set, in SI units.

    as_is: accuracy of the model as its file has it. If the file has no calibration for this set,
    the calibration is fitted to the set, and `calibrated` is True. held_out: accuracy with
    calibration, and effects that have standard errors, fitted again to the other folds, so that
    every fold (a protocol or a block, see `holdout`) is predicted without its own data.
    calibration: the one behind `as_is`.

    data: the set that was judged; table: its samples. residual_as_is, residual (samples,): measured
    minus predicted values behind `as_is` and `held_out`. at_bound: names of the fitted calibration
    parameters that lie on a bound.
    """

    model: Model
    calibration: Mapping[str, Any]
    calibrated: bool
    holdout: str
    as_is: Accuracy
    held_out: Accuracy
    floor: NoiseFloor
    data: MeasurementSet
    table: SampleTable
    residual_as_is: Array
    residual: Array
    at_bound: tuple[str, ...] = ()


def errors_of(data: MeasurementSet, model: Model, tell: Tell = tell_nobody) -> Errors:
    """Errors of a model on a set.

    Raises ValueError for data that the model cannot use.
    """
    tell("fitting", 1, PROGRESS_STEPS)
    problem, given = pose_problem(data, model, {})
    data = problem.data
    tell("holding data out", 2, PROGRESS_STEPS)
    scored = score_base(problem, [effect.name for effect in given])
    forward = Forward(data, model.base, (), model.effects, model.calibration, joints=model.springs)
    calibrated = not all(_given(model, data, name) for name in _names(forward))
    values = _fitted(forward, scored) if calibrated else forward.start()
    as_is = forward.measured - forward.predict(values[None])[0]
    held_out = scored.held_out.residual
    return Errors(
        model=model,
        calibration=calibration_of(scored) if calibrated else model.calibration,
        calibrated=calibrated,
        holdout=data.table.holdout,
        as_is=accuracy(data.table.value, as_is, data.table.output),
        held_out=accuracy(data.table.value, held_out, data.table.output),
        floor=problem.floor,
        data=data,
        table=data.table,
        residual_as_is=as_is,
        residual=held_out,
        at_bound=calibration_at_bound(scored) if calibrated else (),
    )


def _fitted(forward: Forward, scored: Scored) -> Array:
    """Fitted values (k,) of a forward model's parameters, which are the calibration."""
    names = [parameter.name for parameter in scored.fit.likelihood.parameters]
    fitted = dict(zip(names, scored.fit.values, strict=True))
    return np.array([fitted[parameter.name] for parameter in forward.parameters])


def _names(forward: Forward) -> list[str]:
    return [parameter.name for parameter in forward.parameters]


def _given(model: Model, data: MeasurementSet, parameter: str) -> bool:
    """Whether the model's file has a value of the calibration such as `modulus_scale[A]`; where the
    modulus is free, a value of the modulus counts too.
    """
    key, _, member = parameter.rstrip("]").partition("[")
    value = model.calibration.get(key)
    if value is None and key == "modulus_scale" and data.free_modulus:
        value = model.calibration.get("modulus")
    return value is not None and (not isinstance(value, Mapping) or member in value)


@dataclass(frozen=True)
class Part:
    """Accuracy of the model on a part of the set, such as a run: `as_is` and `held_out` as in
    `Errors`.
    """

    name: str
    as_is: Accuracy
    held_out: Accuracy


@dataclass(frozen=True)
class Comparison:
    """A model compared with a measurement set, in SI units.

    runs, specimens, outputs: accuracy on each of these parts. localisation: where the held-out
    residual is large. relation: how the residual follows the input. notices: anomalies of the set.
    slips: mistakes in how the data are stated; the other results are about the data as stated.
    fits_mended: whether the corrected data fit about to the noise floor. series: what happened
    between the runs, as their repeats show. within: tests of the residual within runs; None if no
    run has times. outside: why no model can be judged by these data; "" if one can.
    """

    data: MeasurementSet
    errors: Errors
    runs: tuple[Part, ...]
    specimens: tuple[Part, ...]
    outputs: tuple[Part, ...]
    localisation: Localisation
    relation: InputRelation | None
    notices: tuple[Notice, ...]
    slips: tuple[Slip, ...] = ()
    fits_mended: bool = True
    series: Series = NO_SERIES
    within: WithinRuns | None = None
    outside: str = ""


def compare(
    data: MeasurementSet, model: Model, seed: int = 0, tell: Tell = tell_nobody
) -> Comparison:
    """Compare a model with a measurement set.

    seed: seed of the random draws of the localisation; the same seed gives the same answer. Raises
    ValueError for data that the model cannot use.
    """
    checked = find_slips(data, model, tell)
    errors = errors_of(data, model, tell)
    tell("localising the error", 3, PROGRESS_STEPS)
    found = localise(data, errors.residual, seed)
    specimens = list(dict.fromkeys(run.specimen for run in data.runs))
    specimen_of = np.array([specimens.index(run.specimen) for run in data.runs])[errors.table.run]
    return Comparison(
        data,
        errors,
        _parts(errors, [run.name for run in data.runs], errors.table.run),
        _parts(errors, specimens, specimen_of),
        _parts(errors, data.outputs, errors.table.output),
        found,
        input_relation(data, errors.residual),
        notices(errors.data, errors.floor, errors.residual),
        checked.slips,
        not checked.slips or score(checked.data, model).explains,
        _series(errors, model),
        residual_tests(errors.data, errors.residual),
        outside=outside(checked.data, model.base) or "",
    )


def _series(errors: Errors, model: Model) -> Series:
    """What happened in the series of runs."""

    def error_without(events: Sequence[Event]) -> float:
        return score(without_events(errors.data, events), model).rmse

    return examine_lowering(errors.data, errors.residual, errors.floor, error_without)


def _parts(errors: Errors, names: Sequence[str], index: IntArray) -> tuple[Part, ...]:
    """One part for each name; index (samples,): the number of the name."""
    small = index.astype(np.min_scalar_type(len(names)))  # short numbers are sorted by counting
    order = np.argsort(small, kind="stable")
    counts = np.bincount(index)
    return tuple(
        _part(errors, name, order[end - count : end])
        for name, end, count in zip(names, np.cumsum(counts), counts, strict=True)
    )


def _part(errors: Errors, name: str, samples: IntArray) -> Part:
    measured, output = errors.table.value[samples], errors.table.output[samples]
    return Part(
        name,
        accuracy(measured, errors.residual_as_is[samples], output),
        accuracy(measured, errors.residual[samples], output),
    )
