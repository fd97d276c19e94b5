"""Inputs that jump: held from one sample to the next, instead of rising in straight lines.

Between two samples an input is taken to go in a straight line. A regulator's command is held
instead, and jumps as it is recorded. Where that is so the jump gets a sample of its own: the value
that was held, an instant before.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from model_lab.aliases import Indices
from model_lab.measurements.measurement_set import MeasurementSet, Run
from model_lab.rules import RULES

DRIVING_COLUMN = {"free_bending": "pressure", "blocked_tip": "pressure", "uniaxial": "stretch"}
INSTANT = 1e-6  # of the time between samples


def jumps(data: MeasurementSet, run: Run) -> Indices:
    """Indices of samples of a run at which the input has jumped: with constant values before and
    after, or on any step of a staircase.
    """
    driving = DRIVING_COLUMN.get(data.experiment)
    if driving is None or "time" not in run.columns or run.samples < 2:
        return np.zeros(0, np.int64)
    change = np.abs(np.diff(run.columns[driving]))
    beside = np.maximum(np.append(0.0, change[:-1]), np.append(change[1:], 0.0))
    large = change > RULES.jump_size * float(np.ptp(run.columns[driving]))
    alone = large & (beside <= RULES.jump_flat * change)
    stairs = change[alone].sum() >= RULES.jump_stairs * change.sum()
    return np.asarray(1 + np.flatnonzero(large if stairs else alone), np.int64)


def with_jumps(data: MeasurementSet) -> tuple[MeasurementSet, Indices]:
    """(the set with one more sample just before each jump, at which the earlier value is still
    held; indices of the original samples).
    """
    places = [jumps(data, run) for run in data.runs]
    runs = tuple(_with_held(run, at) for run, at in zip(data.runs, places, strict=True))
    added = np.concatenate(
        [np.bincount(at, minlength=run.samples) for run, at in zip(data.runs, places, strict=True)]
    )
    kept = np.arange(len(added)) + np.cumsum(added)
    return replace(data, runs=runs, jumps=False), kept


def _with_held(run: Run, at: Indices) -> Run:
    """The run with one sample more an instant before each of some."""
    columns = {name: np.insert(values, at, values[at - 1]) for name, values in run.columns.items()}
    time = run.columns.get("time", np.zeros(run.samples))
    instant = time[at] - INSTANT * (time[at] - time[at - 1])
    return replace(
        run, columns={**columns, **({"time": np.insert(time, at, instant)} if len(at) else {})}
    )
