"""What recording does to columns (runs, samples): steps, wild samples, another clock."""

from __future__ import annotations

import numpy as np

Array = np.ndarray


def in_steps(values: Array, steps: int) -> Array:
    """Values of a sensor that tells so many steps over its range; 0: any value.

    >>> in_steps(np.array([[0.0, 0.4, 1.0]]), 4)
    array([[0. , 0.5, 1. ]])
    """
    if not steps:
        return values
    step = np.ptp(values) / steps
    low = values.min()
    return low + step * np.round((values - low) / step)


def gone_wild(values: Array, share: float, rng: np.random.Generator) -> Array:
    """A share of the samples is anywhere within twice the range of what is measured."""
    low, high = values.min(), values.max()
    anything = rng.uniform(low - (high - low) / 2, high + (high - low) / 2, values.shape)
    return np.where(rng.random(values.shape) < share, anything, values)


def latest(time: Array, values: Array, rate: float, rng: np.random.Generator) -> Array:
    """The latest reading at each time [s], of a clock with `rate` readings a sample."""
    rows = []
    for t, row in zip(time, values, strict=True):
        step = (t[1] - t[0]) / rate
        phase = rng.uniform(0.0, step)
        rows.append(np.interp(np.floor((t - phase) / step) * step + phase, t, row))
    return np.array(rows)
