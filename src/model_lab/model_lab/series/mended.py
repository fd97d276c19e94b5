"""A set without the events in its series: steps and drifts taken out, odd runs set aside."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from model_lab.measurements.measurement_set import MeasurementSet, Run
from model_lab.series.events import STEP_OR_DRIFT, Event
from model_lab.series.run_scale import LOAD_SCALE, OUTPUT_SCALE


def without_events(data: MeasurementSet, events: Sequence[Event]) -> MeasurementSet:
    """The set without its events. Readings after a step, or during a drift, are changed to what
    they would have been before it. If the load changed, pressures are changed instead: to those at
    which the specimen, as it was before, would have given the readings. Odd runs are left out.
    """
    set_aside = {event.run for event in events if event.kind not in STEP_OR_DRIFT}
    courses = [event for event in events if event.kind in STEP_OR_DRIFT]
    runs = tuple(
        _without(data, run, index, courses)
        for index, run in enumerate(data.runs)
        if run.name not in set_aside
    )
    return replace(data, runs=runs)


def _without(data: MeasurementSet, run: Run, index: int, events: Sequence[Event]) -> Run:
    columns = dict(run.columns)
    for event in events:
        share = float(event.pattern.shape[index])
        if event.quantity == LOAD_SCALE:
            columns["pressure"] = columns["pressure"] * np.exp(np.log1p(event.size) * share)
            continue
        for output, name in enumerate(data.outputs):
            if name in columns and event.quantity == OUTPUT_SCALE:
                columns[name] = columns[name] * np.exp(-np.log1p(event.size) * share)
            elif name in columns and output == event.output:
                columns[name] = columns[name] - event.size * share
    return replace(run, columns=columns)
