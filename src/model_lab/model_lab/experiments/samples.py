"""Rows of the runs of a set, all at once or step by step, and the modulus calibration of their
rubber.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import cached_property, partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from model_lab.aliases import Array, Indices
from model_lab.measurements.bent_input import begun, bends, between
from model_lab.measurements.measurement_set import TEMPERATURE, MeasurementSet
from softhand_model.bending.whole_runs import Runs
from softhand_model.effects import Effect
from softhand_model.effects.pipeline import StagedEffects, overrides
from softhand_model.effects.stages import InputEffect, Memory
from softhand_model.effects.whole_runs import LONG, in_whole_runs

Step = Callable[[Array, Array], Array]
"""Output (lanes, runs, 1) at the end of a step, given the input (lanes, runs, 1) at its end and its
duration (runs, 1) [s].
"""
NO_TIME = np.zeros(1)  # [s] of a step that takes none
USUAL_MODULUS_SCALES = (0.85, 1.15)  # of a batch, if its modulus is not what is sought
JUMP = 1e-3  # of the usual time between samples: what is nearer belongs to a jump
ROWS_AT_ONCE = 2048  # so that the numbers of ten lanes stay in the cache


def batches(data: MeasurementSet) -> list[str]:
    """Names of the batches to which the specimens of the runs belong, in the order of the runs."""
    return list(dict.fromkeys(data.specimens[run.specimen].batch for run in data.runs))


def modulus_scales(data: MeasurementSet) -> dict[str, float]:
    """Start values, by name, of the factors on the shear modulus of each batch."""
    return {f"modulus_scale[{batch}]": 1.0 for batch in batches(data)}


def modulus_of_runs(data: MeasurementSet, calibration: Mapping[str, Array]) -> Array:
    """Factor (lanes, runs, 1) on the shear modulus of each run, from calibration values (lanes,) by
    name.
    """
    of_runs = [f"modulus_scale[{data.specimens[run.specimen].batch}]" for run in data.runs]
    scales = [np.atleast_1d(calibration.get(name, 1.0)) for name in of_runs]
    found = np.empty((max(map(len, scales)), len(scales), 1))
    for run, scale in enumerate(scales):
        found[:, run, 0] = scale
    return found


class SampleRows:
    """Layout of arrays (lanes, rows, sections): one row per sample of a set, one run after the
    other.

    run (rows,): index of the run of each row.
    """

    def __init__(self, data: MeasurementSet) -> None:
        self._data = data
        counts = np.array([run.samples for run in data.runs])
        self._starts = np.cumsum(counts) - counts
        self.run = np.repeat(np.arange(len(counts)), counts)
        # (ticks, runs): the row of each tick of each run, the last one again after its end
        self._padded = self._starts + np.minimum(np.arange(counts.max())[:, None], counts - 1)
        self._tick = np.arange(len(self.run)) - self._starts[self.run]
        self._steady = np.array([run.steady for run in data.runs])[:, None]
        self._axes: dict[str, NDArray[Any]] = {}

    @cached_property
    def runs(self) -> Runs:
        """The runs with the durations of their steps."""
        counts = [run.samples for run in self._data.runs]
        times = [run.columns.get("time", np.zeros(run.samples)) for run in self._data.runs]
        latest: dict[str, int] = {}
        before = []
        for index, run in enumerate(self._data.runs):
            before.append(-1 if run.virgin else latest.get(run.specimen, -1))
            latest[run.specimen] = index
        return Runs(
            np.concatenate([[0], np.cumsum(counts)]),
            np.concatenate([np.diff(time, prepend=time[:1]) for time in times]).astype(float),
            np.array([run.steady for run in self._data.runs]),
            np.array(before, np.intp),
        )

    def column(self, name: str) -> Array:
        """A column of the set, (1, rows, 1)."""
        parts = [np.asarray(run.columns[name], float) for run in self._data.runs]
        return np.concatenate(parts)[None, :, None]

    def modulus_factor(self, staged: StagedEffects) -> Array | float:
        """Shear modulus (lanes, runs, 1) over its nominal value, at the temperature of each run."""
        self._surround(staged.load, self._starts)
        temperature = np.array([run.temperature for run in self._data.runs])
        return staged.modulus_factor(temperature[None, :, None])

    def warming(self, staged: StagedEffects) -> Array | float:
        """Shear modulus (lanes, rows, 1) over that of `modulus_factor`, where a run has a column of
        its temperature. The load goes with its inverse, a force or stress with itself.
        """
        if not any(TEMPERATURE in run.columns for run in self._data.runs):
            return 1.0
        whole = self.modulus_factor(staged) + np.zeros((1, len(self._starts), 1))
        self._surround(staged.load, slice(None))
        warmth = np.concatenate([run.warmth for run in self._data.runs])
        return staged.modulus_factor(warmth[None, :, None]) / whole[:, self.run]

    def peaks(self, values: Array) -> Array:
        """Largest value (lanes, runs, 1) in each run, of values (lanes, rows, 1)."""
        return np.maximum.reduceat(values, self._starts, axis=1)

    def through(
        self, staged: StagedEffects, effects: Sequence[Effect], method: str, values: Array
    ) -> Array:
        """Outputs (lanes, rows, 1) of effects, applied one after the other by their method of this
        name to values (lanes, rows, 1). An effect with memory and without `in_runs` is stepped.
        """
        for effect in effects:
            values = self._through_one(effect, method, staged.memory[effect.name], values)
        return values

    def _through_one(self, effect: Effect, method: str, memory: Memory, values: Array) -> Array:
        act, in_runs = getattr(effect, method), in_whole_runs(effect, method)
        if in_runs is None and effect.has_memory:
            surround = partial(self._surround, [effect])
            return self.in_steps(lambda value, dt: act(value, memory, dt), values, surround)
        self._surround([effect], slice(None))
        found: Array = in_runs(values, self.runs) if in_runs else act(values, memory, NO_TIME)
        return found

    def chamber_pressure(self, staged: StagedEffects, reading: Array) -> Array:
        """Pressure (lanes, rows, 1) [Pa] in the chamber when the sensor reads `reading` (1, rows,
        1) [Pa].
        """
        if staged.delays:
            reading = self._delayed(staged, reading)
        acting = [e for e in staged.input if overrides(e, InputEffect, "chamber_pressure")]
        return self.through(staged, acting, "chamber_pressure", reading)

    def _delayed(self, staged: StagedEffects, reading: Array) -> Array:
        """The reading (lanes, rows, 1) as it was when what shows now was read.

        A run that does not start steady was at 0 one sample before it. Jumps go from one sample to
        the next here: which delay suits them best could not be sought otherwise.
        """
        elapsed = self.column("time")
        elapsed = elapsed - elapsed[:, self._starts][:, self.run]
        wanted = elapsed - staged.delay(elapsed)
        parts = zip(np.split(elapsed[0, :, 0], self._starts[1:]), self._steady[:, 0], strict=True)
        found, start = np.empty_like(wanted), 0
        for time, steady in parts:
            mine = slice(start, start := start + len(time))
            found[:, mine] = _delayed(time, reading[0, mine, 0], bool(steady), wanted[:, mine])
        return found

    def reading(self, staged: StagedEffects, output: str, values: Array) -> Array:
        """Readings (lanes, rows) of the sensor of an output, with the effects of `staged` that act
        on sensors. values (lanes, rows, 1): the true values; a lane is one set of parameters.
        """
        acting = [effect for effect in staged.output if effect.shows(output)]
        return self.through(staged, acting, "reading", values)[:, :, 0]

    def _surround(self, effects: Sequence[Effect], rows: Indices | slice) -> None:
        """Pass effects the values of their axes (`Effect.around`) at the rows of a call."""
        for effect in effects:
            if effect.axes:
                around = {axis: self._axis(axis)[rows][None, :, None] for axis in effect.axes}
                effect.around = around

    def _axis(self, name: str) -> NDArray[Any]:
        """Values, or names, (rows,) of an axis on which an effect may depend."""
        if name not in self._axes:
            if name == "pressure":
                found = np.concatenate([self._data.driving(run) for run in self._data.runs])
            else:
                found = np.array(self._data.of_runs(name))[self.run]
            self._axes[name] = found
        return self._axes[name]

    def at_once(
        self, function: Callable[[Array, Indices], Array], values: Array, sections: int = 1
    ) -> Array:
        """Outputs (lanes, rows, 1) of a function of inputs (lanes, rows, 1) and of the run (rows,)
        of each row.

        To limit the memory, it is called for some of the rows at a time: the fewer, the more
        `sections` each row has.
        """
        size = max(ROWS_AT_ONCE // sections, 1)
        parts = [slice(edge, edge + size) for edge in range(0, len(self.run), size)]
        return np.concatenate([function(values[:, part], self.run[part]) for part in parts], axis=1)

    def in_steps(
        self, step: Step, values: Array, surround: Callable[[Indices], None] = lambda _rows: None
    ) -> Array:
        """Outputs (lanes, rows, 1) of a function with memory, stepped through all runs at the same
        time.

        It starts at rest, and the first sample takes no time; runs that start steady have had the
        input of their first sample for a long time. surround: called before each step with the rows
        (runs,) of the step.
        """
        in_order = np.ascontiguousarray(values[:, self._padded].swapaxes(0, 1))
        if self._steady.any():
            surround(self._starts)
            step(in_order[0] * self._steady, LONG * self._steady)
        outputs = []
        for rows, inputs, dt in zip(self._padded, in_order, self._durations(), strict=True):
            surround(rows)
            outputs.append(step(inputs, dt))
        return np.stack(outputs).swapaxes(0, 1)[:, self._tick, self.run]

    def _durations(self) -> Array:
        """Time (ticks, runs, 1) [s] from sample to sample; 0 at the first and after the last."""
        time = self.column("time")[0, :, 0][self._padded]
        return np.diff(time, axis=0, prepend=time[:1])[:, :, None]


def _delayed(time: Array, values: Array, steady: bool, wanted: Array) -> Array:
    """The course of a run (n,) at wanted times since it began, of any shape."""
    known, course = begun(time, values, float(values[0]) if steady else 0.0)
    steps = np.diff(known, append=np.inf)
    alone = steps > JUMP * np.median(steps)
    known, course = known[alone], course[alone]
    within = np.clip(wanted, known[0], known[-1])
    return between(known, course, bends(known, course), within)
