"""Prediction of tests of the rubber itself in several modes: one law for all of them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from model_lab.aliases import Array
from model_lab.experiments.samples import modulus_scales
from model_lab.experiments.uniaxial import SHAPELESS, Uniaxial
from model_lab.measurements.measurement_set import MODES, MeasurementSet
from softhand_model.effects import Effect


class Rubber:
    """Nominal stresses (lanes, samples) [Pa], run after run: G*(Q + nu + s_c*w) in the mode of each
    run.

    The largest stretch of a specimen carries over to later runs of the same mode only, as each mode
    is tested on a sample of its own. Raises DocumentError for a specimen without shear_modulus.
    """

    def __init__(self, data: MeasurementSet) -> None:
        self._data = data
        self._parts = [
            (np.flatnonzero(np.isin(data.table.run, indices)), Uniaxial(part, mode))
            for mode in MODES
            for indices in [[index for index, run in enumerate(data.runs) if run.mode == mode]]
            if indices
            for part in [replace(data, runs=tuple(data.runs[index] for index in indices))]
        ]
        self.strained = SHAPELESS, "pure_shear"  # the mode of an actuator's wall

    def calibration(self, effects: Sequence[type[Effect] | Effect] = ()) -> dict[str, float]:
        """Start values, by name, of the calibration parameters of a model with these effects."""
        return modulus_scales(self._data)

    def predict(self, calibration: Mapping[str, Array], effects: Sequence[Effect]) -> Array:
        """Stresses (lanes, samples) [Pa]: calibration (lanes,) by name, effects in lanes."""
        parts = [(rows, model.predict(calibration, effects)) for rows, model in self._parts]
        lanes = max(len(stress) for _, stress in parts)
        whole = np.empty((lanes, self._data.table.samples))
        for rows, stress in parts:
            whole[:, rows] = stress
        return whole
