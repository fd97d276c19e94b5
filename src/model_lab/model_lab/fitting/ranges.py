"""Usual ranges of effects' parameters in a set, where they go by what was measured in it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from model_lab.measurements.measurement_set import MeasurementSet
from softhand_model.effects import Effect, Parameter
from softhand_model.effects.effect import OUTPUT_UNIT

SMALLEST = 1e-9  # of a largest value, where nothing was measured


def in_the_range_of(
    data: MeasurementSet, classes: Mapping[str, type[Effect]]
) -> dict[str, type[Effect]]:
    """Classes of effects whose parameters have usual ranges, and units, of this set.

    Those of which no parameter is relative to it stay as they are.
    """
    largest = {
        "pressure": _largest(data, ("pressure",)),
        "output": _largest(data, data.outputs),
    }
    return {name: _placed(effect, largest, data.unit) for name, effect in classes.items()}


def _largest(data: MeasurementSet, names: tuple[str, ...]) -> float:
    """Largest size of these columns over the set."""
    columns = [run.columns[name] for run in data.runs for name in names if name in run.columns]
    return max((float(np.max(np.abs(column))) for column in columns), default=0.0) or SMALLEST


def _placed(effect: type[Effect], largest: Mapping[str, float], unit: str) -> type[Effect]:
    if not any(parameter.relative for parameter in effect.parameters):
        return effect
    placed = tuple(_in_range(parameter, largest, unit) for parameter in effect.parameters)
    return type(effect.__name__, (effect,), {"parameters": placed, "__doc__": effect.__doc__})


def _in_range(parameter: Parameter, largest: Mapping[str, float], unit: str) -> Parameter:
    if parameter.relative is None:
        return parameter
    of, *shares = parameter.relative
    low, high = np.clip(np.array(shares) * largest[of], parameter.low, parameter.high).tolist()
    if not low < high:
        return parameter
    shown = parameter.unit.replace(OUTPUT_UNIT, unit)
    return replace(parameter, unit=shown, typical=(low, high), relative=None)
