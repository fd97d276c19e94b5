"""Prediction of the nominal stress at a stretch, in uniaxial tension or another mode.

The stretch is imposed, so there is nothing to solve. Effects act on the elastic stress as in
bending.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

import numpy as np

from model_lab.aliases import Array
from model_lab.experiments.samples import NO_TIME, SampleRows, Step, modulus_of_runs, modulus_scales
from model_lab.experiments.specimen_models import SpecimenMemory
from model_lab.measurements.measurement_set import INPUTS, MeasurementSet
from model_lab.measurements.rows import require_possible
from model_lab.measurements.specimens import require_columns, require_keys
from model_lab.rules import RULES
from softhand_model.bending.elastic_chain import compiled_effects
from softhand_model.bending.whole_runs import stress_in_runs
from softhand_model.effects import Effect
from softhand_model.effects.pipeline import StagedEffects, remembers
from softhand_model.effects.stages import SectionShape, Strain

GRIP_SECANTS = 3  # then 1e-5 of the stress, where grips are four times as stiff as the rubber
SHAPELESS = SectionShape(NO_TIME, NO_TIME, NO_TIME, NO_TIME, NO_TIME, NO_TIME)


class Uniaxial:
    """Nominal stresses (lanes, samples) [Pa], run after run: G*(Q + nu + s_c*w).

    mode: mode of deformation of all runs, see `effects.stages.Strain`. Raises DocumentError for a
    specimen without shear_modulus.

    lowest: least values of parameters in this set, by name; that of grips, which are stiffer than
    the strip.
    """

    def __init__(self, data: MeasurementSet, mode: str = "uniaxial") -> None:
        self._data, self._mode = data, mode
        require_columns(data, INPUTS[data.experiment], "the model")
        require_possible(data)
        self._rows = SampleRows(data)
        self._memory = SpecimenMemory(self._rows)
        for name in dict.fromkeys(run.specimen for run in data.runs):
            require_keys(
                data, data.specimens[name], ["shear_modulus"], f"the model of {data.experiment}"
            )
        specimens = [data.specimens[run.specimen] for run in data.runs]
        modulus = [specimen.values["shear_modulus"] for specimen in specimens]
        self._modulus = np.array(modulus, float)[None, :, None]
        self.strained = SHAPELESS, mode
        self._stretch = self._rows.column("stretch")
        elongation = self._stretch.ravel() - 1.0
        pulled = elongation > RULES.early_pull * elongation.max(initial=0.0)
        secants = data.table.value[pulled] / elongation[pulled]
        stiffest = max(float(secants.max(initial=0.0)), 0.0)
        self.lowest = {"machine_compliance.stiffness": stiffest / RULES.grips_share}

    def calibration(self, effects: Sequence[type[Effect] | Effect] = ()) -> dict[str, float]:
        """Start values, by name, of the calibration parameters of a model with these effects."""
        return modulus_scales(self._data)

    def predict(self, calibration: Mapping[str, Array], effects: Sequence[Effect]) -> Array:
        """Stresses (lanes, samples) [Pa]: calibration (lanes,) by name, effects in lanes."""
        staged = StagedEffects(effects)
        scale = modulus_of_runs(self._data, calibration)
        modulus = self._modulus * scale * self._rows.modulus_factor(staged)
        modulus = modulus[:, self._rows.run] * self._rows.warming(staged)

        def stress_at(stretch: Array) -> Array:
            return modulus * imposed(staged, self._mode, self._memory, stretch - 1.0)

        read, yields = staged.imposed_stretch(self._stretch), staged.grip_compliance()
        stress = _in_grips(stress_at, read, yields) if np.any(yields) else stress_at(read)
        return self._rows.reading(staged, "stress", stress)


def _in_grips(stress_at: Callable[[Array], Array], read: Array, compliance: Array | float) -> Array:
    """Stress (lanes, rows, 1) [Pa] of strips in grips that yield by `compliance` [1/Pa] times the
    stress, from the stretch with the grips: secants for lambda = read - compliance*stress(lambda).
    """
    stretch, stress = read, stress_at(read)
    strain = read - 1.0
    slope = np.maximum(stress / np.where(strain != 0.0, strain, 1.0), 0.0)
    for _ in range(GRIP_SECANTS):
        ahead = read - compliance * (stress - slope * stretch)
        ahead = np.maximum(ahead / (1.0 + compliance * slope), np.minimum(read, 1.0))
        found = stress_at(ahead)
        moved = ahead - stretch
        rises = (found - stress) / np.where(moved != 0.0, moved, 1.0)
        slope = np.where(moved != 0.0, np.maximum(rises, 0.0), slope)
        stretch, stress = ahead, found
    return stress


def imposed(staged: StagedEffects, mode: str, memory: SpecimenMemory, strain: Array) -> Array:
    """Elastic stress over the modulus, (lanes, rows, 1) [-], of rubber whose strain lambda - 1
    (lanes, rows, 1) is imposed in a mode of `effects.stages.Strain`.
    """

    def step(strain: Array, dt: Array) -> Array:
        state = Strain(1.0 + strain, mode)
        stress = staged.stress(state, SHAPELESS, dt)
        staged.remember(state, SHAPELESS, dt)
        return stress

    def begin() -> Step:
        staged.reset()
        return step

    if remembers(staged.elastic):
        effects = compiled_effects(staged)
        if effects is not None:
            return stress_in_runs(effects, 1.0 + strain, SHAPELESS, memory.runs, mode)
        return memory.in_steps(begin, staged, strain)
    return step(strain, NO_TIME)
