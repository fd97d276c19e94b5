"""Data by which no model can be judged: vacuum, a dead sensor, marks of missing samples."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from scipy.special import fdtrc

from model_lab.aliases import Array
from model_lab.measurements.measurement_set import MeasurementSet
from model_lab.measurements.units import unit_of
from model_lab.rules import RULES

MARK_SAMPLES = 3  # samples of one value that are marks
UNMARKED_READINGS = 5  # different values beside them
CUBIC_TERMS = 4  # coefficients
FITTED_READINGS = 20  # to which a cubic is fitted
ACTUATED = ("free_bending", "blocked_tip", "base_torque")


def outside(data: MeasurementSet, base: str) -> str | None:
    """Why no model can be judged by these data, as a sentence that begins with the column; None if
    one can.
    """
    return below_ambient(data, base) or dead_readings(data)


def dead_readings(data: MeasurementSet) -> str | None:
    """A sentence about outputs that are constant, repeat a number that marks missing samples, or
    are noise that does not follow the input; None if there are none.
    """
    outputs = {
        name: np.concatenate([run.columns[name] for run in data.runs if name in run.columns])
        for name in data.outputs
    }
    driven = np.ptp(np.concatenate([data.driving(run) for run in data.runs])) > 0.0
    if driven and all(np.ptp(values) == 0.0 for values in outputs.values()):
        return _constant(data, outputs)
    found = (_marked(data, name, values) for name, values in outputs.items())
    return next((sentence for sentence in found if sentence), None) or _noise(data)


def _constant(data: MeasurementSet, outputs: Mapping[str, Array]) -> str:
    name, values = next(iter(outputs.items()))
    shown = data.shown_in(unit_of(name) or "").shown(float(values[0]))
    return (
        f"{name}: expected readings that change with the input, got {shown} throughout: look at "
        "the sensor and its plug"
    )


def _marked(data: MeasurementSet, name: str, values: Array) -> str | None:
    """A sentence about values (n,) that repeat one number far from all others."""
    shown = data.shown_in(unit_of(name) or "").shown
    for end in (float(values.max()), float(values.min())):
        others = values[values != end]
        count = len(values) - len(others)
        if count < MARK_SAMPLES or len(np.unique(others)) < UNMARKED_READINGS:
            continue
        if float(np.min(np.abs(others - end))) > RULES.mark_distance * float(np.ptp(others)):
            return (
                f"{name}: expected readings, got {shown(end, 5)} in {count} samples, where all "
                f"others lie between {shown(float(others.min()))} and "
                f"{shown(float(others.max()))}: if it marks missing samples, take these rows out"
            )
    return None


def _noise(data: MeasurementSet) -> str | None:
    """A sentence about a single output of which no cubic of the input explains more than of white
    noise (F test).
    """
    if len(data.outputs) > 1 or data.experiment == "valve_pulse":
        return None
    driving = np.concatenate([data.driving(run) for run in data.runs])
    values = np.concatenate([run.columns[data.outputs[0]] for run in data.runs])
    if len(values) < FITTED_READINGS or np.ptp(driving) == 0.0:
        return None
    rows = np.vander((driving - driving.mean()) / np.ptp(driving), CUBIC_TERMS)
    left = float(np.sum((values - rows @ np.linalg.lstsq(rows, values, rcond=None)[0]) ** 2))
    whole, freedom = float(np.sum((values - values.mean()) ** 2)), len(values) - CUBIC_TERMS
    ratio = (whole - left) / (CUBIC_TERMS - 1) / max(left / freedom, 1e-300)
    if float(fdtrc(CUBIC_TERMS - 1, freedom, ratio)) < RULES.dead_p_value:
        return None
    shown = data.output_display.shown(float(np.std(values)))
    return (
        f"{data.outputs[0]}: expected readings that follow the input, got readings that vary by "
        f"{shown} (rms) whatever the input is: look at the sensor, its plug, and the columns"
    )


def below_ambient(data: MeasurementSet, base: str) -> str | None:
    """A sentence about pressures below ambient, for which the model has no equations; None if there
    are none, or if the base model is not one of an actuator under pressure. Pressures that are
    below zero at rest do not count, as there the zero of the sensor is wrong.
    """
    if base == "linear" or data.experiment not in ACTUATED:
        return None
    pressure = np.concatenate([run.columns.get("pressure", np.zeros(1)) for run in data.runs])
    starts = [run.columns["pressure"][0] for run in data.runs if "pressure" in run.columns]
    at_rest = float(np.median(starts)) if starts else 0.0
    is_zero = -RULES.gauge_zero * float(np.ptp(pressure)) <= at_rest < 0.0
    least = RULES.vacuum + (at_rest if is_zero else 0.0)
    if float(np.mean(pressure < least)) <= RULES.vacuum_share:
        return None
    shown = data.shown_in("Pa").shown(float(pressure.min()))
    return (
        "pressure: the model is one of inflation: expected gauge pressures of 0 or more, got "
        f"pressures down to {shown}, which is below the air around; a chamber that is sucked flat "
        "bends by other laws; leave these runs out, take --model linear with an effect of your "
        "own, or state the pressures anew if they are inflations (columns: {pressure: {is: "
        "negative, ...}})"
    )
