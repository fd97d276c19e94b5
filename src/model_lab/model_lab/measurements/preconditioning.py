"""Preconditioning: how far a specimen was stretched before a run, in pulls that are not recorded as
runs.

Rubber is softer below the largest stretch that it has seen (L. Mullins). A set states that stretch
by `stretched_to`, and a model is driven to it before the run; what it predicts there is not used.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from model_lab.aliases import Indices
from model_lab.measurements.measurement_set import MeasurementSet, Run


def with_preconditioning(data: MeasurementSet) -> tuple[MeasurementSet, Indices | slice]:
    """(the set with a pull before each run that states one, indices of the original samples)."""
    if not any(run.stretched_to > 1.0 for run in data.runs):
        return data, slice(None)
    parts = [part for run in data.runs for part in _with_pull(run)]
    own = np.concatenate([np.full(run.samples, is_own) for run, is_own in parts])
    return replace(data, runs=tuple(run for run, _ in parts)), np.flatnonzero(own)


def _with_pull(run: Run) -> Iterator[tuple[Run, bool]]:
    """A run and before it its pull, each with whether it is the run."""
    if run.stretched_to > 1.0:
        columns = {name: np.repeat(values[:1], 2) for name, values in run.columns.items()}
        columns["stretch"] = np.array([1.0, run.stretched_to])
        if "time" in columns:
            columns["time"] = np.array([0.0, 1.0])  # any [s]: the run itself starts at rest
        pull = replace(run, name=f"before {run.name}", columns=columns, lead={}, stretched_to=1.0)
        yield pull, False
        run = replace(run, virgin=False)
    yield run, True
