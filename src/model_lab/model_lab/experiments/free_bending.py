"""Prediction of free bending: the tip angle under pressure (lab.md, eq. 3.12 and 3.30)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import partial

import numpy as np
from numpy.typing import NDArray

from model_lab.experiments.calibrated import modulus_of_runs, modulus_scales
from model_lab.experiments.sample_rows import SampleRows, Step
from model_lab.experiments.specimen_memory import SpecimenMemory
from model_lab.experiments.specimen_sections import SpecimenSections
from model_lab.measurement import MeasurementSet
from softhand_model.effects import Effect
from softhand_model.effects.staged import StagedEffects, at_modulus, remembers
from softhand_model.effects.stages import SectionShape
from softhand_model.free_bending import SteppedBalance, free_curvature

Array = NDArray[np.float64]


class FreeBending:
    """Tip angles (lanes, samples) [rad], run after run.

    Raises DocumentError for a specimen that lacks a key of the model.
    """

    def __init__(self, data: MeasurementSet) -> None:
        self._data = data
        self._rows = SampleRows(data)
        self._memory = SpecimenMemory(data, self._rows)
        self._sections = SpecimenSections(data, uniform=True)
        self._pressure = self._rows.column("pressure")

    def calibration(self, effects: Sequence[type[Effect] | Effect] = ()) -> dict[str, float]:
        """Names of the calibration with the values from which a search starts."""
        return modulus_scales(self._data)

    def predict(self, calibration: Mapping[str, Array], effects: Sequence[Effect]) -> Array:
        """Tip angles (lanes, samples) [rad]: calibration (lanes,) by name, effects in lanes."""
        staged = StagedEffects(effects)
        modulus = modulus_of_runs(self._data, calibration)
        modulus = modulus * staged.modulus_factor(self._rows.temperature())
        shape = at_modulus(self._sections.shape, modulus)
        pressure = self._rows.through(
            staged.chamber_pressure, remembers(staged.input), self._pressure
        )
        angle = self._angle(staged, shape, pressure)
        shown = partial(staged.reading, "tip_angle")
        return self._rows.through(shown, remembers(staged.output), angle)[:, :, 0]

    def _angle(self, staged: StagedEffects, shape: SectionShape, pressure: Array) -> Array:
        """Tip angle (lanes, rows, 1) [rad] at chamber pressures (lanes, rows, 1) [Pa]."""
        weight = self._sections.weight

        def tip(stepped: SteppedBalance, at: SectionShape, of: Array, *step: Array) -> Array:
            curvature = free_curvature(stepped, step[0], at, step[1])
            return np.sum(of * curvature, axis=-1, keepdims=True)

        def begin() -> Step:
            return partial(tip, SteppedBalance(staged), shape, weight)

        if remembers(staged.elastic):
            return self._memory.in_steps(begin, staged, pressure)
        return self._rows.at_once(
            lambda part, run: tip(
                SteppedBalance(staged), shape.of_rows(run), weight[:, run], part, np.zeros(1)
            ),
            pressure,
        )
