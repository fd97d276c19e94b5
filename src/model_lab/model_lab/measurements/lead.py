"""The lead of a run: its inputs before the first output was measured.

If a camera starts some seconds late, or its clock is late, there are inputs without outputs.
Effects with memory depend on these inputs, so a model is driven with them too, and its predictions
for them are not used. Outputs are compared from the first measured one on.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from model_lab.aliases import Array, Indices
from model_lab.measurements.held_input import DRIVING_COLUMN
from model_lab.measurements.measurement_set import MeasurementSet, Run


def with_lead(data: MeasurementSet) -> tuple[MeasurementSet, Indices | slice]:
    """(the set with the leads of its runs as samples, indices of the original samples).

    In the lead, outputs, which were not measured, have the first measured value.
    """
    if data.experiment not in DRIVING_COLUMN or not any(run.lead for run in data.runs):
        return data, slice(None)
    runs = tuple(_with_lead(run) for run in data.runs)
    own = [
        np.arange(led.samples) >= led.samples - run.samples
        for run, led in zip(data.runs, runs, strict=True)
    ]
    return replace(data, runs=runs), np.flatnonzero(np.concatenate(own))


def parted(columns: Mapping[str, Array], outputs: tuple[str, ...]) -> tuple[dict, dict]:
    """(columns (rows,) from the first measured output on, lead).

    The lead has the rows before, without outputs, which are NaN there; it is empty if there are no
    such rows.
    """
    first = max((int(np.isnan(columns[name]).sum()) for name in outputs), default=0)
    if first == 0:
        return dict(columns), {}
    lead = {name: values[:first] for name, values in columns.items() if name not in outputs}
    return {name: values[first:] for name, values in columns.items()}, lead


def _with_lead(run: Run) -> Run:
    if not run.lead:
        return run
    missing = np.ones(len(next(iter(run.lead.values()))))
    columns = {
        name: np.concatenate([run.lead.get(name, missing * values[0]), values])
        for name, values in run.columns.items()
    }
    return replace(run, columns=columns, lead={})
