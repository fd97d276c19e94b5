"""The base `linear`: output = coefficient*input, for actuators whose inside is not known.

Effects get u = y/y_ref in place of the load q and the strain lambda - 1, where y_ref is the largest
base output of the set.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from model_lab.aliases import Array, Mask
from model_lab.experiments.samples import NO_TIME, SampleRows, Step
from model_lab.experiments.specimen_models import SpecimenMemory
from model_lab.experiments.uniaxial import SHAPELESS, imposed
from model_lab.measurements.measurement_set import INPUTS, MeasurementSet
from model_lab.measurements.rows import require_possible
from model_lab.measurements.specimens import require_columns
from softhand_model.bending.balance import SteppedBalance
from softhand_model.bending.elastic_chain import compiled_effects
from softhand_model.bending.whole_runs import stretch_in_runs
from softhand_model.effects import Effect
from softhand_model.effects.pipeline import StagedEffects, remembers

LINEAR_EXPERIMENTS = ("free_bending", "blocked_tip", "uniaxial")


class LinearBase:
    """Outputs (lanes, samples), run after run, of sets whose input is a pressure or a stretch.

    Raises ValueError for a set of another experiment.
    """

    def __init__(self, data: MeasurementSet) -> None:
        if data.experiment not in LINEAR_EXPERIMENTS:
            raise ValueError(
                f"base linear: expected one of the experiments {', '.join(LINEAR_EXPERIMENTS)}, "
                f"got {data.experiment}"
            )
        self._data, self._output = data, data.outputs[0]
        require_columns(data, INPUTS[data.experiment], "the model")
        require_possible(data)
        self._rows = SampleRows(data)
        self._memory = SpecimenMemory(self._rows)
        self.strained = SHAPELESS, "linear"
        self._imposed = data.experiment == "uniaxial"
        self._input = (
            self._rows.column("stretch") - 1.0 if self._imposed else self._rows.column("pressure")
        )

    def calibration(self, effects: Sequence[type[Effect] | Effect] = ()) -> dict[str, float]:
        """Coefficient of each specimen by name, with its least-squares value.

        It is 1 for a specimen without measured outputs, or whose input is 0 throughout.
        """
        found = {}
        for name in dict.fromkeys(run.specimen for run in self._data.runs):
            rows = np.array([run.specimen == name for run in self._data.runs])[self._rows.run]
            found[f"coefficient[{name}]"] = self._least_squares(rows)
        return found

    def _least_squares(self, rows: Mask) -> float:
        if any(self._output not in run.columns for run in self._data.runs):
            return 1.0
        given = self._input[0, rows, 0]
        square = float(given @ given)
        return (
            float(given @ self._rows.column(self._output)[0, rows, 0]) / square if square else 1.0
        )

    def predict(self, calibration: Mapping[str, Array], effects: Sequence[Effect]) -> Array:
        """Outputs (lanes, samples): calibration (lanes,) by name, effects in lanes."""
        staged, rows = StagedEffects(effects), self._rows
        names = [f"coefficient[{run.specimen}]" for run in self._data.runs]
        slopes = np.stack(
            np.broadcast_arrays(*(np.atleast_1d(calibration[name]) for name in names)), axis=1
        )
        slope = slopes[:, rows.run, None]
        largest = np.max(np.abs(slope * self._input), axis=1, keepdims=True)
        largest = np.where(largest > 0.0, largest, 1.0)
        modulus = rows.modulus_factor(staged) * np.ones((1, len(names), 1))
        respond = self._stretched if self._imposed else self._pressed
        output = largest * respond(staged, slope / largest, modulus[:, rows.run])
        return rows.reading(staged, self._output, output)

    def _stretched(self, staged: StagedEffects, slope: Array, modulus: Array) -> Array:
        """Output over its largest value (lanes, rows, 1), if the input is a stretch."""
        return modulus * imposed(staged, "linear", self._memory, slope * self._input)

    def _pressed(self, staged: StagedEffects, slope: Array, modulus: Array) -> Array:
        """Output over its largest value (lanes, rows, 1), if the input is a pressure."""
        rows = self._rows
        pressure = rows.chamber_pressure(staged, self._input)
        load = staged.act_on_load(slope * pressure / modulus, pressure, SHAPELESS)
        effects = compiled_effects(staged)
        if not staged.elastic:
            return load
        if effects is not None:
            return stretch_in_runs(effects, load, SHAPELESS, rows.runs, "linear") - 1.0

        def begin() -> Step:
            stepped = SteppedBalance(staged, "linear")
            return lambda load, dt: stepped.stretch(load, SHAPELESS, dt) - 1.0

        if remembers(staged.elastic):
            return self._memory.in_steps(begin, staged, load)
        return rows.at_once(lambda part, _run: begin()(part, NO_TIME), load)
