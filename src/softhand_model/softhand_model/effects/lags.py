"""Kernel of effects that relax or creep: a sum of lags.

Each lag stores the difference d between the stress Q and a value that follows Q with the time
constant tau: d' = -d/tau + Q'. Its weight times d is added to the stress. So over a step the result
of such an effect is linear in the stress, and known before the stretch is sought.
"""

from __future__ import annotations

import numpy as np

from softhand_common.numerics.arrays import Array
from softhand_common.numerics.compiled import compiled
from softhand_model.effects.kernel import Kernel, Trial

# values: what counts at once, then the weights of the lags, then their time constants [s]
AT_ONCE, WEIGHT = 0, 1
# state: a straight line over the stress, the step's duration and the stress; then for each lag what
# the stress is ahead of it, and what the step leaves and lets through of that
SCALE, SHIFT, LASTS, BEFORE, AHEAD = range(5)
SAME_STEP = 1e-9  # relative difference of two durations that are one


def lags_kernel(lags: int) -> Kernel:
    """The kernel for a number of lags. Its rows of values are the share of the stress that acts at
    once, then the weights, then the time constants [s].
    """
    return Kernel(_act, _begin_step, rest=(0.0, 0.0, -1.0, 0.0, *(3 * lags * [0.0])))


@compiled
def _act(stress: Array, trial: Trial, values: Array, state: Array) -> None:
    if trial.accepted:
        _follow(stress, state, len(values) // 2)
    for lane in range(len(stress)):
        stress[lane] = stress[lane] * state[SCALE, lane] + state[SHIFT, lane]


@compiled
def _begin_step(dt: float, values: Array, state: Array) -> None:
    lanes, lags = range(values.shape[1]), len(values) // 2
    left, share, time = AHEAD + lags, AHEAD + 2 * lags, WEIGHT + lags
    if abs(dt - state[LASTS, 0]) > SAME_STEP * dt:
        state[LASTS] = dt
        for lag in range(lags):
            for lane in lanes:
                steps = dt / values[time + lag, lane]
                gone = -np.expm1(-steps)
                state[left + lag, lane] = 1.0 - gone
                state[share + lag, lane] = gone / steps if steps > 0.0 else 1.0
    state[SCALE], state[SHIFT] = values[AT_ONCE], 0.0
    for lag in range(lags):
        for lane in lanes:
            weight, passed = values[WEIGHT + lag, lane], state[share + lag, lane]
            ahead = state[left + lag, lane] * state[AHEAD + lag, lane]
            state[SCALE, lane] += weight * passed
            state[SHIFT, lane] += weight * (ahead - passed * state[BEFORE, lane])


@compiled
def _follow(stress: Array, state: Array, lags: int) -> None:
    """Take over the stress (lanes,) at the end of a step; the line over it stays as it was."""
    left, share = AHEAD + lags, AHEAD + 2 * lags
    for lag in range(lags):
        for lane in range(len(stress)):
            ahead = state[left + lag, lane] * state[AHEAD + lag, lane]
            moved = state[share + lag, lane] * (stress[lane] - state[BEFORE, lane])
            state[AHEAD + lag, lane] = ahead + moved
    for lane in range(len(stress)):
        state[BEFORE, lane] = stress[lane]
