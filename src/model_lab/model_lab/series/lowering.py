"""Events that count: taking a step or drift out of the set must lower the error of a model that is
right but for them.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

from model_lab.aliases import Array
from model_lab.fitting.noise_floor import NoiseFloor
from model_lab.measurements.measurement_set import MeasurementSet
from model_lab.rules import RULES
from model_lab.series.events import SLOW_COURSE, STEP_OR_DRIFT, Event, Series, examine


def examine_lowering(
    data: MeasurementSet,
    residual: Array,
    floor: NoiseFloor,
    error_without: Callable[[Sequence[Event]], float],
) -> Series:
    """Find events as `examine` does, but drop steps and drifts, also doubted ones, that raise the
    error of the model when they are taken out: two odd runs, for example, may look like a drift of
    all runs. The error of a model that fails anyway may rise by a little (`Rules.event_rise`).

    residual (samples,): as for `examine`. error_without: returns the held-out error of the
    model on the set without some events, in the SI unit of the outputs.
    """
    refused: tuple[str, ...] = ()
    fails = error_without(()) > RULES.material_error * floor.total
    most = error_without(()) * (RULES.event_rise if fails else 1.0)
    while True:
        series = examine(data, residual, floor.within, refused)
        courses = [e.kind for e in series.events if e.kind in STEP_OR_DRIFT]
        doubted = series.doubted if series.doubted and series.doubted.kind != SLOW_COURSE else None
        taken_out = series.events if courses else tuple(filter(None, [doubted]))
        if not taken_out or error_without(taken_out) <= most:
            return series
        if not courses:
            return replace(series, doubted=None)
        refused = (*refused, *courses)
