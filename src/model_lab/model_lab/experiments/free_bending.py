"""Prediction of free bending: the tip angle under pressure (eq. 3.12 and 3.30)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from model_lab.aliases import Array, Indices
from model_lab.experiments.samples import NO_TIME, SampleRows, Step, modulus_of_runs, modulus_scales
from model_lab.experiments.specimen_models import SpecimenMemory, SpecimenSections, numbers
from model_lab.measurements.measurement_set import INPUTS, MeasurementSet, Specimen
from model_lab.measurements.specimens import require_columns, require_keys
from softhand_model.bending.balance import (
    SteppedBalance,
    balance,
    free_curvature,
)
from softhand_model.bending.loaded_finger import Weight
from softhand_model.bending.whole_runs import curvature_in_runs
from softhand_model.effects import Effect
from softhand_model.effects.load import STANDARD_GRAVITY
from softhand_model.effects.pipeline import StagedEffects, at_modulus, remembers
from softhand_model.effects.stages import SectionShape

# share of the weight that acts in the plane of bending, and tilt [rad] of the base: see Weight
WEIGHT_OF_MOUNT = {
    "bending_plane_level": (0.0, 0.0),
    "base_up": (1.0, 0.0),
    "base_down": (-1.0, 0.0),
    "level_curling_up": (1.0, np.pi / 2.0),
    "level_curling_down": (-1.0, np.pi / 2.0),
}
SAMPLES_A_GROUP = 16  # samples in which a finger moves little


class FreeBending:
    """Tip angles (lanes, samples) [rad], run after run.

    Raises DocumentError for a specimen that lacks a key of the model (`predict` does so for the
    mass, if gravity acts), ValueError for a mount that is not in WEIGHT_OF_MOUNT.
    """

    def __init__(self, data: MeasurementSet) -> None:
        self._data = data
        require_columns(data, INPUTS["free_bending"], "the model")
        self._rows = SampleRows(data)
        self._memory = SpecimenMemory(self._rows)
        self._pressure = self._rows.column("pressure")
        self._specimens = [data.specimens[run.specimen] for run in data.runs]
        mounts = np.array([_weight_of_mount(specimen) for specimen in self._specimens])
        self._shares, self._tilts = mounts.T[:, None, :, None]
        self._uniform = SpecimenSections(data, uniform=True)
        self.strained = self._uniform.shape, "pure_shear"

    @cached_property
    def _fine(self) -> SpecimenSections:
        """Sections for a curvature that varies along uniform specimens too."""
        return SpecimenSections(self._data, uniform=False)

    def calibration(self, effects: Sequence[type[Effect] | Effect] = ()) -> dict[str, float]:
        """Start values, by name, of the calibration parameters of a model with these effects."""
        return modulus_scales(self._data)

    def predict(self, calibration: Mapping[str, Array], effects: Sequence[Effect]) -> Array:
        """Tip angles (lanes, samples) [rad]: calibration (lanes,) by name, effects in lanes."""
        staged = StagedEffects(effects)
        modulus = modulus_of_runs(self._data, calibration)
        modulus = modulus * self._rows.modulus_factor(staged)
        pressure = self._rows.chamber_pressure(staged, self._pressure)
        pressure = pressure / self._rows.warming(staged)  # as the load is, but for a weight
        angle = self._angle(staged, modulus, pressure)
        return self._rows.reading(staged, "tip_angle", angle)

    def _angle(self, staged: StagedEffects, modulus: Array, pressure: Array) -> Array:
        """Tip angle (lanes, rows, 1) [rad] at chamber pressures (lanes, rows, 1) [Pa]."""
        finger = self._finger(staged, modulus)
        if finger.weight is None:
            curvature = curvature_in_runs(staged, pressure, finger.shape, self._rows.runs)
            if curvature is not None:
                weights = finger.weights[:, self._rows.run]
                return np.sum(weights * curvature, axis=-1, keepdims=True)

        def begin() -> Step:
            return finger.stepping(SteppedBalance(staged))

        if remembers(staged.elastic):
            return self._memory.in_steps(begin, staged, pressure)
        return self._rows.at_once(
            lambda part, run: finger.of_rows(run).stepping(SteppedBalance(staged), SAMPLES_A_GROUP)(
                part, NO_TIME
            ),
            pressure,
            finger.weights.shape[-1],
        )

    def _finger(self, staged: StagedEffects, modulus: Array) -> _Fingers:
        """The fingers of the runs, with their weight and what hangs at their tips, if `gravity` or
        `tip_load` acts on any of them.
        """
        scales = [one.values["mass_scale"] for one in staged.load if one.name == "gravity"]
        tips = [one.values["mass"] for one in staged.load if one.name == "tip_load"]
        if not (scales or tips) or not self._shares.any():
            shape = at_modulus(self._uniform.shape, modulus)
            return _Fingers(shape, self._uniform.weight, None)
        fine = self._fine
        beyond = np.sum(tips, axis=0) + 0.0 * fine.x
        if scales:
            for specimen in self._specimens:
                require_keys(self._data, specimen, ["mass"], "gravity")
            own = np.sum(scales, axis=0) * numbers(self._specimens, "mass")
            beyond = beyond + own * (fine.length - fine.x) / fine.length
        pull = self._shares * STANDARD_GRAVITY * beyond
        weight = Weight(pull, self._tilts, fine.weight, fine.running)
        return _Fingers(at_modulus(fine.shape, modulus), fine.weight, weight)


@dataclass(frozen=True)
class _Fingers:
    """Sections (lanes, rows, sections) along fingers, their weights [m], and what pulls at them."""

    shape: SectionShape
    weights: Array
    weight: Weight | None

    def of_rows(self, rows: Indices) -> _Fingers:
        """Some of the rows, or rows that repeat."""
        weight = None if self.weight is None else self.weight.of_rows(rows)
        return _Fingers(self.shape.of_rows(rows), self.weights[:, rows], weight)

    def stepping(self, stepped: SteppedBalance, alike: int = 1) -> Step:
        """Tip angle (lanes, rows, 1) [rad] after a step to a pressure [Pa]; rows as many as alike
        follow each other closely.
        """
        solver = balance if self.weight is None else self.weight.solver(self.shape, alike)

        def step(pressure: Array, dt: Array) -> Array:
            curvature = free_curvature(stepped, pressure, self.shape, dt, solver)
            return np.sum(self.weights * curvature, axis=-1, keepdims=True)

        return step


def _weight_of_mount(specimen: Specimen) -> tuple[float, float]:
    if specimen.mount not in WEIGHT_OF_MOUNT:
        raise ValueError(
            f"specimen {specimen.name}: mount: expected one of {', '.join(WEIGHT_OF_MOUNT)}, "
            f"got {specimen.mount}"
        )
    return WEIGHT_OF_MOUNT[specimen.mount]
