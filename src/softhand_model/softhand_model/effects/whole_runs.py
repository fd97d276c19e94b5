"""Results of effects with memory for whole runs, computed at once instead of step by step."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from softhand_common.numerics.arrays import Array, Flags, Indices
from softhand_common.numerics.compiled import compiled
from softhand_model.effects.effect import Effect

LONG = 1e12  # [s] after which all transients have ended


@dataclass(frozen=True)
class RunTimes:
    """Times of the samples of runs, one run after the other.

    starts (runs + 1,): first row of each run, and the number of rows. dt (rows,) [s]: duration of
    the step to each sample; 0 at the first sample of a run. steady (runs,): whether a run has been
    in the state of its first sample for long; others start at rest.
    """

    starts: Indices
    dt: Array
    steady: Flags

    def elapsed(self) -> Array:
        """Time (1, rows, 1) [s] since the run of each row began."""
        time = np.cumsum(self.dt)
        return (time - np.repeat(time[self.starts[:-1]], np.diff(self.starts)))[None, :, None]


def in_whole_runs(effect: Effect, method: str) -> Callable[[Array, RunTimes], Array] | None:
    """The method `in_runs` of an effect; None without one, or if a derived class has overridden
    only `method`, the method of the stage whose results `in_runs` gives.
    """
    for owner in type(effect).__mro__:
        if "in_runs" in vars(owner):
            found: Callable[[Array, RunTimes], Array] | None = getattr(effect, "in_runs", None)
            return found
        if method in vars(owner):
            return None
    return None


def lagged_in_runs(
    values: Array,
    times: RunTimes,
    time_constant: Array | float,
    doubling: Array | float | None = None,
) -> Array:
    """First-order lag (lanes, rows, 1) of `values` (lanes or 1, rows, 1), with a time constant [s]
    for each lane (lanes,), a set of trial values. It starts anew in each run (`RunTimes.steady`).

    doubling (lanes,): following value at which the time constant has doubled; it grows in
    proportion. None: it is constant.
    """
    constants = np.ravel(np.asarray(time_constant, float))
    lanes = max(len(values), len(constants))
    given = np.empty((values.shape[1], lanes))
    given[:] = values[:, :, 0].T
    constants = np.array(np.broadcast_to(constants, lanes))
    found = np.empty_like(given)
    if doubling is None:
        _lag(given, constants, times.starts, times.dt, times.steady, found)
    else:
        doubles = np.array(np.broadcast_to(np.ravel(np.asarray(doubling, float)), lanes))
        _growing(given, constants, doubles, times.starts, times.dt, times.steady, found)
    return found.T[:, :, None]


@compiled
def _lag(
    values: Array, constants: Array, starts: Indices, dt: Array, steady: Flags, found: Array
) -> None:
    """Fill found (rows, lanes) with what follows values (rows, lanes)."""
    lanes = values.shape[1]
    left, share = np.empty(lanes), np.empty(lanes)
    follows, before = np.empty(lanes), np.empty(lanes)
    for run in range(len(steady)):
        lasts = -1.0
        for lane in range(lanes):
            follows[lane] = before[lane] = 0.0
            if steady[run]:
                before[lane] = values[starts[run], lane]
                follows[lane] = before[lane] * (1.0 - constants[lane] / LONG)
        for row in range(starts[run], starts[run + 1]):
            if dt[row] != lasts:
                lasts = dt[row]
                for lane in range(lanes):
                    steps = lasts / constants[lane]
                    gone = -np.expm1(-steps)
                    left[lane] = 1.0 - gone
                    share[lane] = gone / steps if steps > 0.0 else 1.0
            for lane in range(lanes):
                value = values[row, lane]
                rest = left[lane] * (follows[lane] - before[lane])
                follows[lane] = value - share[lane] * (value - before[lane]) + rest
                before[lane] = value
                found[row, lane] = follows[lane]


@compiled
def _growing(
    values: Array,
    constants: Array,
    doubles: Array,
    starts: Indices,
    dt: Array,
    steady: Flags,
    found: Array,
) -> None:
    """As `_lag`, with time constants that grow with the following value."""
    for lane in range(values.shape[1]):
        for run in range(len(steady)):
            before = follows = 0.0
            if steady[run]:
                before = values[starts[run], lane]
                middle = max(before, 0.0) / 2.0
                follows = before * (1.0 - constants[lane] * (1.0 + middle / doubles[lane]) / LONG)
            for row in range(starts[run], starts[run + 1]):
                value, start, middle = values[row, lane], follows, follows
                for _ in range(2):
                    constant = constants[lane] * (1.0 + max(middle, 0.0) / doubles[lane])
                    steps = dt[row] / constant
                    gone = -np.expm1(-steps)
                    share = gone / steps if steps > 0.0 else 1.0
                    rest = (1.0 - gone) * (start - before)
                    follows = value - share * (value - before) + rest
                    middle = (start + follows) / 2.0
                before = value
                found[row, lane] = follows
