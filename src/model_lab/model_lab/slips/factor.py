"""Whether a slip that is a mere factor, such as a wrong unit, is exactly the factor that the data
of a blocked tip lack.

Its force barely depends on the modulus, so the calibration takes up no factor. Wrong sizes of the
specimens, or an actuator of another make, change the force by a factor too, and that lies near the
ratio of some two units by chance. Only a unit leaves none.
"""

from __future__ import annotations

import numpy as np

from model_lab.aliases import Array
from model_lab.measurements.measurement_set import MeasurementSet
from model_lab.rules import RULES

MERE_FACTORS = ("unit", "percent", "radius", "wall_total")  # kinds of slips


def is_mere_factor(name: str, column: str) -> bool:
    """Whether a slip of a kind and column changes a force by about a factor."""
    return name in MERE_FACTORS and column != "time"


def is_other_factor(name: str, column: str, factor: float) -> bool:
    """Whether a slip is a mere factor, and leaves one so large that it is not that of the data."""
    most = np.log1p(RULES.slip_factor_most)
    return is_mere_factor(name, column) and bool(abs(np.log(max(factor, 1e-9))) > most)


def factor_left(data: MeasurementSet, predicted: Array) -> float:
    """The factor by which measured forces of a blocked tip differ from predicted ones (samples,),
    if it lies beyond what runs scatter, and beyond `Rules.slip_factor`; else, and in all other
    experiments, 1.
    """
    square = float(predicted @ predicted)
    if data.experiment != "blocked_tip" or not square > 0.0:
        return 1.0
    table, runs = data.table, len(data.runs)
    power = np.bincount(table.run, predicted**2, runs)
    along = np.bincount(table.run, predicted * table.value, runs)
    factor = float(along.sum()) / square
    spread = float(np.linalg.norm(along - factor * power)) / square
    off = abs(factor - 1.0) - RULES.slip_factor_errors * spread
    return factor if off > RULES.slip_factor else 1.0


def acts_as_factor(base: Array, final: Array) -> bool:
    """Whether a final prediction (samples,) differs from the base prediction (samples,) mainly by a
    factor: effects that were added then only take up what the slip leaves.
    """
    square = float(base @ base)
    factor = float(base @ final) / square if square > 0.0 else 1.0
    shape = float(np.linalg.norm(final - factor * base))
    return shape < RULES.slip_shape * abs(factor - 1.0) * float(np.linalg.norm(base))
