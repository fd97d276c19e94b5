"""Events that count: taking a step or drift out of the set must lower the error of the model."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

from model_lab.aliases import Array
from model_lab.measurements.measurement_set import MeasurementSet
from model_lab.series.events import STEP_OR_DRIFT, Event, Series, examine


def examine_lowering(
    data: MeasurementSet,
    residual: Array,
    within: float,
    error_without: Callable[[Sequence[Event]], float],
) -> Series:
    """Find events as `examine` does, but drop steps and drifts, also doubted ones, that raise the
    error of the model when they are taken out: two odd runs, for example, may look like a drift of
    all runs.

    residual (samples,), within: as for `examine`. error_without: returns the held-out error of the
    model on the set without some events, in the SI unit of the outputs.
    """
    refused: tuple[str, ...] = ()
    while True:
        series = examine(data, residual, within, refused)
        courses = [e.kind for e in series.events if e.kind in STEP_OR_DRIFT]
        taken_out = series.events if courses else tuple(filter(None, [series.doubted]))
        if not taken_out or error_without(taken_out) <= error_without(()):
            return series
        if not courses:
            return replace(series, doubted=None)
        refused = (*refused, *courses)
