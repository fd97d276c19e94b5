"""Inputs without the steps of a coarse sensor.

A lag or a late clock smooths the steps by which a coarse sensor rounds, so a model with one of them
predicts better than one without, though nothing lags. Where a reading goes to the next step, the
input was halfway between both; between such times it is taken to go straight. What is left, as
where noise lets a reading flicker between two steps, is smoothed as noise of the input is, but not
what is held.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from model_lab.aliases import Array
from model_lab.measurements.held_input import DRIVING_COLUMN
from model_lab.measurements.measurement_set import MeasurementSet, Run
from model_lab.measurements.preprocess import by_parabolas
from model_lab.measurements.resolution import held_still, sensor_step
from model_lab.rules import RULES


def without_rounding(data: MeasurementSet) -> MeasurementSet | None:
    """The set with the rounding of its input removed; None if its sensor is not seen to be coarse,
    or without time. Where next to nothing was removed, inputs that were made in steps, as those of
    a program are, may be no rounding.
    """
    name = DRIVING_COLUMN.get(data.experiment)
    if name is None or not data.has_time:
        return None
    step = sensor_step([run.columns[name] for run in data.runs], RULES.input_levels)
    if not step:
        return None
    runs, taken = zip(*(_unrounded_run(run, name, step) for run in data.runs), strict=True)
    rounded = np.sqrt(np.mean(np.concatenate(taken) ** 2)) >= RULES.input_rounded * step
    return replace(data, runs=runs, input_step=step if rounded else 0.0)


def _unrounded_run(run: Run, name: str, step: float) -> tuple[Run, Array]:
    """(the run without the rounding of a column, what was taken out (k,) before smoothing)."""
    parts = [run.lead, run.columns] if name in run.lead else [run.columns]
    time, values = (np.concatenate([part[key] for part in parts]) for key in ("time", name))
    course = unrounded(time, values, step)
    smooth = by_parabolas(course, step / np.sqrt(12.0))
    whole = np.where(held_still(course, step), course, smooth)
    before = len(whole) - run.samples
    lead = {**run.lead, name: whole[:before]} if before else run.lead
    new = replace(run, columns={**run.columns, name: whole[before:]}, lead=lead)
    return new, course - values


def unrounded(time: Array, readings: Array, step: float) -> Array:
    """The course (n,) of which readings (n,) at times (n,) are rounded to whole steps.

    >>> unrounded(np.arange(6.0), np.array([0.0, 0.0, 1.0, 1.0, 2.0, 2.0]), 1.0)
    array([0.        , 0.33333333, 0.75      , 1.25      , 1.66666667,
           2.        ])
    """
    after = 1 + np.flatnonzero(np.diff(readings))
    if not len(after):
        return readings
    changes = 0.5 * (time[after - 1] + time[after])
    level = readings[np.append(0, after)]
    rises = np.diff(level)
    one = np.abs(rises) < RULES.input_one_step * step
    begins, ends = np.append(time[0], changes), np.append(changes, time[-1])
    lasts = ends - begins
    halfway = 0.5 * (level[:-1] + level[1:])
    known = [*zip(changes[one].tolist(), halfway[one].tolist(), strict=True)]
    for place, value in enumerate(level):
        into = place > 0 and bool(one[place - 1])
        out = place < len(rises) and bool(one[place])
        before = lasts[place - 1] if into else 0.0
        later = lasts[place + 1] if out else 0.0
        passes = into and out and rises[place - 1] * rises[place] > 0.0
        if passes and lasts[place] <= RULES.input_holds * max(before, later):
            continue
        first, last = begins[place] + 0.5 * before, ends[place] - 0.5 * later
        if first <= last:
            inside = (time >= begins[place]) & (time <= ends[place])
            held = time[inside & (time >= first) & (time <= last)]
            known += [(float(at), float(value)) for at in (held if len(held) else [first])]
        elif into and out:
            reach = min(1.0, lasts[place] / (before + later))
            turn = value + (reach - 0.5) * float(np.sign(rises[place - 1])) * step
            known.append((0.5 * (begins[place] + ends[place]), turn))
        else:
            known.append((begins[place] if out else ends[place], value))
    at, values = np.array(sorted(known)).T
    found = np.interp(time, at, values)
    return np.clip(found, readings - 0.5 * step, readings + 0.5 * step)
