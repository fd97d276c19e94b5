"""Ladder of errors: several models against one measurement set."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from model_lab.aliases import Tell, tell_nobody
from model_lab.comparison.compare import Errors, errors_of
from model_lab.fitting.noise_floor import NoiseFloor
from model_lab.measurements.measurement_set import MeasurementSet
from softhand_model.model_file import Model


@dataclass(frozen=True)
class Rung:
    """One model and its errors."""

    name: str
    errors: Errors


@dataclass(frozen=True)
class Ladder:
    """Several models on the same measurement set, in the order in which they were named."""

    data: MeasurementSet
    rungs: tuple[Rung, ...]

    @property
    def best(self) -> Rung:
        """The model with the smallest held-out error."""
        return min(self.rungs, key=lambda rung: rung.errors.held_out.rmse)

    @property
    def floor(self) -> NoiseFloor:
        """The noise floor as stated for the best model: from repeats if there are any."""
        return self.best.errors.floor


def compare_models(
    data: MeasurementSet, models: Mapping[str, Model], tell: Tell = tell_nobody
) -> Ladder:
    """Compare each of the models, given by name, with the set.

    Raises ValueError for data that a model cannot use; the message names the model.
    """
    rungs = []
    for number, (name, model) in enumerate(models.items(), 1):
        tell(name, number, len(models))
        try:
            rungs.append(Rung(name, errors_of(data, model)))
        except ValueError as reason:
            raise ValueError(f"model {name}: {reason}") from reason
    return Ladder(data, tuple(rungs))
