"""What a specimen remembers from run to run: its largest values so far."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping

import numpy as np
from numpy.typing import NDArray

from model_lab.experiments.sample_rows import LONG, SampleRows, Step
from model_lab.measurement import MeasurementSet
from softhand_model.effects.staged import StagedEffects

Array = NDArray[np.float64]
Entry = tuple[str, str]  # name of an effect and of what it keeps
Largest = Mapping[Entry, Array]
"""Largest values (lanes, runs, sections) so far."""

PASSES = 3  # over all runs, until these values agree at ends and starts
UNCHANGED = 1e-9


class SpecimenMemory:
    """Steps through the runs of a set, whose specimens carry over their largest values in order.

    The runs are stepped together, so what a run starts with is guessed from the peaks of those
    before it, and mended in further passes where time has changed these peaks.
    """

    def __init__(self, data: MeasurementSet, rows: SampleRows) -> None:
        self._rows = rows
        self._before: list[int | None] = []
        latest: dict[str, int] = {}
        for index, run in enumerate(data.runs):
            self._before.append(None if run.virgin else latest.get(run.specimen))
            latest[run.specimen] = index

    def in_steps(self, begin: Callable[[], Step], staged: StagedEffects, values: Array) -> Array:
        """Outputs (lanes, rows, 1) for inputs (lanes, rows, 1); begin resets and gives the step."""
        kept = {
            (effect.name, key): virgin
            for effect in staged.elastic
            for key, virgin in effect.largest.items()
        }
        if not kept:
            return self._rows.in_steps(begin(), values)
        begin()(self._rows.peaks(values), np.full((len(self._before), 1), LONG))
        carried = self._carried(_largest(staged, kept), kept)
        for _ in range(PASSES):
            outputs = self._pass(begin, staged, values, carried)
            guessed, carried = carried, self._carried(_largest(staged, kept), kept)
            if all(np.all(np.abs(carried[k] - guessed[k]) <= UNCHANGED) for k in carried):
                break
        return outputs

    def _pass(
        self, begin: Callable[[], Step], staged: StagedEffects, values: Array, carried: Largest
    ) -> Array:
        step = begin()
        for (name, key), value in carried.items():
            staged.memory[name][key] = value
        return self._rows.in_steps(step, values)

    def _carried(self, ends: Largest, virgin: Mapping[Entry, float]) -> Largest:
        """What runs start with, given what they end with and what a virgin specimen has."""
        starts = {}
        for key, end in ends.items():
            start = np.full_like(end, virgin[key])
            for run, before in enumerate(self._before):
                if before is not None:
                    start[:, run] = np.maximum(start[:, before], end[:, before])
            starts[key] = start
        return starts


def _largest(staged: StagedEffects, kept: Iterable[Entry]) -> Largest:
    return {(name, key): np.asarray(staged.memory[name][key]) for name, key in kept}
