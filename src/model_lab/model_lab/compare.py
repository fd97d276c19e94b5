"""Comparison of a model with a measurement set: how large the error is, and where it lies."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from model_lab.accuracy import Accuracy, accuracy
from model_lab.errors import Errors, errors_of
from model_lab.input_relation import InputRelation, input_relation
from model_lab.localise import Localisation, localise
from model_lab.measurement import MeasurementSet
from softhand_model.model_file import Model

IntArray = NDArray[np.int64]
Tell = Callable[[float], None]


@dataclass(frozen=True)
class Part:
    """Accuracy of the model on a part of the set: as it is, and held out."""

    name: str
    as_is: Accuracy
    held_out: Accuracy


@dataclass(frozen=True)
class Comparison:
    """A model against a measurement set, in SI units.

    runs, specimens, outputs: the errors in parts. localisation, relation: of the held-out residual.
    """

    data: MeasurementSet
    errors: Errors
    runs: tuple[Part, ...]
    specimens: tuple[Part, ...]
    outputs: tuple[Part, ...]
    localisation: Localisation
    relation: InputRelation | None


def compare(
    data: MeasurementSet, model: Model, seed: int = 0, tell: Tell = lambda _: None
) -> Comparison:
    """Compare a model with a set.

    seed: of the tests of the localisation; same seed, same answer. tell: is told the part that is
    done. Raises ValueError for data that the model cannot use.
    """
    errors = errors_of(data, model, lambda part: tell(0.7 * part))
    found = localise(data, errors.residual, seed)
    tell(0.95)
    specimens = list(dict.fromkeys(run.specimen for run in data.runs))
    specimen_of = np.array([specimens.index(run.specimen) for run in data.runs])[errors.run_of]
    return Comparison(
        data,
        errors,
        _parts(errors, [run.name for run in data.runs], errors.run_of),
        _parts(errors, specimens, specimen_of),
        _parts(errors, data.outputs, errors.output_of),
        found,
        input_relation(data, errors.residual),
    )


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
    measured, output = errors.measured[samples], errors.output_of[samples]
    return Part(
        name,
        accuracy(measured, errors.residual_as_is[samples], output),
        accuracy(measured, errors.residual[samples], output),
    )
