"""Data that lie outside of what the model describes, whatever its parameters."""

from __future__ import annotations

import numpy as np

from model_lab.measurements.measurement_set import MeasurementSet
from model_lab.rules import RULES

ACTUATED = ("free_bending", "blocked_tip", "base_torque")


def below_ambient(data: MeasurementSet, base: str) -> str | None:
    """A sentence about pressures below that of the air, which the model does not describe; None
    where there are none, or the base is no model of an actuator.
    """
    if base == "linear" or data.experiment not in ACTUATED:
        return None
    pressure = np.concatenate([run.columns.get("pressure", np.zeros(1)) for run in data.runs])
    if float(np.mean(pressure < RULES.vacuum)) <= RULES.vacuum_share:
        return None
    least = data.shown_in("Pa").shown(float(pressure.min()))
    return (
        "the model is one of inflation: expected gauge pressures of 0 or more, got pressures down "
        f"to {least}, which is below the air around; a chamber that is sucked flat bends by other "
        "laws; leave these runs out, take --model linear with an effect of your own, or state the "
        "pressures anew if they are inflations (columns: {pressure: {is: negative, ...}})"
    )
