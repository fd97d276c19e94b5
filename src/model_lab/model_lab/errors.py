"""Errors of a model on a measurement set: on all of it, and on runs that were held out."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from model_lab.accuracy import Accuracy, accuracy
from model_lab.estimates import calibration_of
from model_lab.forward import Forward
from model_lab.measurement import MeasurementSet
from model_lab.noise import NoiseFloor
from model_lab.question import pose_question
from model_lab.search import Scored, score_base
from softhand_model.model_file import Model

Array = NDArray[np.float64]
IntArray = NDArray[np.int64]
Tell = Callable[[float], None]


@dataclass(frozen=True)
class Errors:
    """Errors of a model, in SI units.

    as_is: of the model as its file has it; its calibration is fitted to the set if the file has
    none for it (`calibrated` says so). held_out: with the calibration, and effects that carry
    standard errors, fitted anew, so that every protocol (or block, as `holdout` says) is predicted
    without its own data. calibration: the one of as_is.

    measured, residual_as_is, residual (samples,): run by run and output by output, as run_of and
    output_of say; residual is the held-out one.
    """

    model: Model
    calibration: Mapping[str, Any]
    calibrated: bool
    holdout: str
    as_is: Accuracy
    held_out: Accuracy
    floor: NoiseFloor
    measured: Array
    residual_as_is: Array
    residual: Array
    run_of: IntArray
    output_of: IntArray


def errors_of(data: MeasurementSet, model: Model, tell: Tell = lambda _: None) -> Errors:
    """Errors of a model on a set.

    tell: is told the part that is done. Raises ValueError for data that the model cannot use.
    """
    question, given = pose_question(data, model, {})
    data = question.data
    tell(0.4)
    scored = score_base(question, [effect.name for effect in given])
    tell(0.9)
    forward = Forward(data, model.base, (), model.effects, model.calibration, joints=model.springs)
    calibrated = not all(_given(model, parameter.name) for parameter in forward.parameters)
    values = _fitted(forward, scored) if calibrated else forward.start()
    as_is = forward.measured - forward.predict(values[None])[0]
    held_out = scored.held_out.residual
    return Errors(
        model=model,
        calibration=calibration_of(scored) if calibrated else model.calibration,
        calibrated=calibrated,
        holdout=question.spectrum.layout.holdout,
        as_is=accuracy(forward.measured, as_is, forward.output_of),
        held_out=accuracy(forward.measured, held_out, forward.output_of),
        floor=question.floor,
        measured=forward.measured,
        residual_as_is=as_is,
        residual=held_out,
        run_of=forward.run_of,
        output_of=forward.output_of,
    )


def _fitted(forward: Forward, scored: Scored) -> Array:
    """Fitted values (k,) of a forward model's parameters, which are the calibration."""
    names = [parameter.name for parameter in scored.fit.problem.forward.parameters]
    fitted = dict(zip(names, scored.fit.values, strict=True))
    return np.array([fitted[parameter.name] for parameter in forward.parameters])


def _given(model: Model, parameter: str) -> bool:
    """Whether the model's file has a value of the calibration such as `modulus_scale[A]`."""
    key, _, member = parameter.rstrip("]").partition("[")
    value = model.calibration.get(key)
    return value is not None and (not isinstance(value, Mapping) or member in value)
