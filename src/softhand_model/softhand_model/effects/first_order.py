"""Exact steps of first-order lags, for inputs that change in a straight line over the step."""

from __future__ import annotations

from typing import Any

import numpy as np

from softhand_model.effects.stages import Array, Memory


def decay(dt: Array | float, time_constant: Any) -> tuple[Array, Array]:
    """What is left of a start after dt [s], exp(-x), and the share (1 - exp(-x))/x [-] that a ramp
    over the step leaves at its end, x = dt/time_constant.

    >>> left, share = decay(0.0, 1.0)
    >>> float(left), float(share)
    (1.0, 1.0)
    """
    steps = np.asarray(dt, float) / time_constant
    gone = -np.expm1(-steps)
    return 1.0 - gone, np.where(steps > 0.0, gone, 1.0) / np.where(steps > 0.0, steps, 1.0)


def lagged(value: Array, memory: Memory, dt: Array | float, time_constant: Any) -> Array:
    """What follows a value with a time constant [s] after a step of dt [s], at 0 before the first.

    memory keeps what follows, and the value.
    """
    follows, before = memory.get("state", (0.0, 0.0))
    left, share = decay(dt, time_constant)
    follows = value - share * (value - before) + left * (follows - before)
    memory["state"] = follows, value
    return follows
