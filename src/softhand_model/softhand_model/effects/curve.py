"""Curves for effects that nobody has an equation for yet: smooth, by values at knots.

What a curve is a function of may be an argument of the effect's method, what the input has done so
far (`Course`), or an axis of the run (`Effect.around`).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from softhand_common.numerics.arrays import Array
from softhand_model.effects.stages import Memory


def smooth_curve(knots: Sequence[float], values: Mapping[str, Any], place: Array | float) -> Array:
    """Values (lanes, rows, sections) of a curve that is smooth between its knots and constant
    beyond them.

    Between two knots it is a cubic; its slope at a knot is that of the parabola through three
    knots. So the curve is linear in its values, and each value changes it only nearby.

    Args:
        knots: rising abscissas (k,) of the knots, at least two.
        values: ordinates at the knots, in their order; numbers, or arrays (lanes, 1, 1).
        place: abscissas at which the curve is evaluated.

    >>> smooth_curve((0.0, 1.0, 2.0), {"a": 0.0, "b": 1.0, "c": 2.0}, np.array([0.5, 9.0])).tolist()
    [0.5, 2.0]
    """
    at, width = np.asarray(knots, float), np.diff(knots)
    heights = _in_lanes(values)
    rise = np.diff(heights) / width
    slope = np.empty_like(heights)
    share = width[1:] / (width[:-1] + width[1:])
    slope[:, 1:-1] = share * rise[:, :-1] + (1.0 - share) * rise[:, 1:]
    slope[:, 0] = rise[:, 0] if len(at) < 3 else 2.0 * rise[:, 0] - slope[:, 1]
    slope[:, -1] = rise[:, -1] if len(at) < 3 else 2.0 * rise[:, -1] - slope[:, -2]
    where = np.clip(place, at[0], at[-1])
    piece = np.clip(np.searchsorted(at, where, side="right") - 1, 0, len(width) - 1)
    lanes, axes = np.arange(len(heights)), max(map(np.ndim, [place, *values.values()]))
    lane = lanes.reshape(-1, *[1] * (axes - 1)) if len(lanes) > 1 else 0
    span = width[piece]
    x = (where - at[piece]) / span
    low, high = heights[lane, piece], heights[lane, piece + 1]
    start, end = span * slope[lane, piece], span * slope[lane, piece + 1]
    bend = 3.0 * (high - low) - 2.0 * start - end
    return np.asarray(low + x * (start + x * (bend + x * (start + end - 2.0 * (high - low)))))


def _in_lanes(values: Mapping[str, Any]) -> Array:
    """Values (lanes, k); one lane for single numbers."""
    columns = [np.ravel(value) for value in values.values()]
    return np.stack(np.broadcast_arrays(*columns), axis=-1).astype(float)


def levels(
    names: Sequence[str], values: Mapping[str, Any], given: Array | None, neutral: float
) -> Array:
    """Value (lanes, rows, 1) for each of the `given` names (1, rows, 1); `neutral` for a name
    without a value, and if no names are given.
    """
    total = np.asarray(neutral)
    if given is None:
        return total
    for name, value in zip(names, values.values(), strict=True):
        total = np.where(given == name, value, total)
    return total


@dataclass(frozen=True)
class Course:
    """The change of a value up to now.

    rate [1/s]: smoothed rate. direction: from -1 (falls) over 0 (rests) to 1 (rises). since [s]:
    time since it last moved; 0 while it moves. time [s]: since the start of the run.
    """

    rate: Array
    direction: Array
    since: Array
    time: Array


def course(value: Array, memory: Memory, dt: Array | float, over: float, slow: float) -> Course:
    """The course of a value after a step of dt [s]; to be called once per step.

    over: time [s] over which the rate is smoothed. slow: rate below which the value counts as at
    rest.
    """
    before, rate, since, time = memory.get("course", (value, 0.0 * value, 0.0 * value, 0.0))
    step = np.asarray(dt, float)
    slope = (value - before) / np.where(step > 0.0, step, 1.0)
    rate = rate + (slope - rate) * -np.expm1(-step / over)
    direction = np.clip(rate / slow, -1.0, 1.0)
    rests = np.minimum(np.abs(rate), np.abs(slope)) < slow  # which the smoothed rate tells late
    since = np.where(rests, since + step, 0.0)
    time = time + step
    memory["course"] = value, rate, since, time
    return Course(rate, direction, since, np.broadcast_to(time, np.shape(rate)))
