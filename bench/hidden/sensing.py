"""Lags, dead zones and what sensors make of a value; all on the fine grid, arrays (runs, steps)."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from scipy.linalg import expm

Array = np.ndarray


def first_order(time: Array, value: Array, time_constant: float) -> Array:
    """First-order lag from zero, exact for a value that is straight between the steps."""
    steps = np.diff(time, axis=1) / time_constant
    keep = np.exp(-steps)
    mean = np.where(steps > 1e-9, -np.expm1(-steps) / np.maximum(steps, 1e-12), 1.0)
    shown = np.zeros_like(value)
    for k in range(steps.shape[1]):
        gain_old, gain_new = mean[:, k] - keep[:, k], 1.0 - mean[:, k]
        shown[:, k + 1] = (
            keep[:, k] * shown[:, k] + gain_old * value[:, k] + gain_new * value[:, k + 1]
        )
    return shown


def integrate(
    time: Array,
    value: Array,
    rate: Callable[[Array, Array], Array],
    states: int,
    fastest: float,
) -> Array:
    """Fourth-order Runge-Kutta of state' = rate(state, value), state (states, runs) from zero.

    `fastest` [1/s] is the quickest rate of the equation: steps are divided until they resolve it.
    """
    parts = int(np.clip(np.ceil(np.diff(time, axis=1).max() * fastest), 1, 200))
    state = np.zeros((states, value.shape[0]))
    out = np.zeros((states, *value.shape))
    for k in range(time.shape[1] - 1):
        h = (time[:, k + 1] - time[:, k]) / parts
        start, rise = value[:, k], (value[:, k + 1] - value[:, k]) / parts
        for part in range(parts):
            k1 = rate(state, start + part * rise)
            k2 = rate(state + h / 2 * k1, start + (part + 0.5) * rise)
            k3 = rate(state + h / 2 * k2, start + (part + 0.5) * rise)
            k4 = rate(state + h * k3, start + (part + 1) * rise)
            state = state + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
        out[:, :, k + 1] = state
    return out


def second_order(time: Array, value: Array, time_constant: float, damping: float = 0.8) -> Array:
    """Second-order lag whose delay of a ramp is `time_constant`, exact for straight pieces."""
    omega = 2 * damping / time_constant
    system = np.zeros((4, 4))  # position, speed, drive and the drive's slope
    system[0, 1], system[2, 3] = 1.0, 1.0
    system[1, :3] = -(omega**2), -2 * damping * omega, omega**2
    steps = time[:, 1] - time[:, 0]
    moves = np.array([expm(system * step) for step in steps])
    state = np.zeros((len(steps), 4))
    shown = np.zeros_like(value)
    for k in range(value.shape[1] - 1):
        state[:, 2], state[:, 3] = value[:, k], (value[:, k + 1] - value[:, k]) / steps
        state = np.einsum("rij,rj->ri", moves, state)
        shown[:, k + 1] = state[:, 0]
    return shown


def orifice(time: Array, value: Array, time_constant: float, scale: float) -> Array:
    """Flow through an orifice: the rate goes with the root of the difference, linear near zero."""

    def rate(state: Array, drive: Array) -> Array:
        gap = (drive - state[0]) / scale
        return (scale / time_constant * gap / np.sqrt(np.abs(gap) + 0.04))[None]

    return integrate(time, value, rate, 1, 5 / time_constant)[0]


def late(time: Array, value: Array, delay: Array | float) -> Array:
    """The value (runs, steps) of a time ago, nothing before the run, its end beyond it."""
    rows = zip(time, value, time - delay, strict=True)
    return np.array([np.interp(then, t, y, left=0.0) for t, y, then in rows])


def seen_aslant(angle: Array, length: float, tilt: float, distance: float) -> Array:
    """Direction [rad] of the tip of an arc (its tip angle [rad], length [m]) as a pinhole camera
    sees it, tilted [rad] about the straight finger, at a distance [m]: that of the last tenth.
    """
    seen = []
    for share in (0.9, 1.0):
        bend = np.where(np.abs(angle) > 1e-9, angle, 1e-9)
        along, across = np.sin(share * bend) / bend, (1 - np.cos(share * bend)) / bend
        depth = 1 + length * across * np.sin(tilt) / distance
        seen.append((along / depth, across * np.cos(tilt) / depth))
    (x, y), (tip_x, tip_y) = seen
    chord = 0.95 * angle  # within pi of what is seen
    raw = np.arctan2(tip_y - y, tip_x - x)
    return (raw + 2 * np.pi * np.round((chord - raw) / (2 * np.pi))) / 0.95


def stuck(value: Array, low: float, high: float) -> Array:
    """A reading that stays at one end of a gap while the value crosses it."""
    shown = value.copy()
    for k in range(value.shape[1]):
        inside = (value[:, k] > low) & (value[:, k] < high)
        before = shown[:, k - 1] if k else np.zeros(len(value))
        shown[:, k] = np.where(inside, np.where(before >= high, high, low), value[:, k])
    return shown


def softplus(value: Array, threshold: float, width: float) -> Array:
    """A dead zone without an edge, zero at zero."""
    at_rest = np.logaddexp(0, -threshold / width)
    return width * (np.logaddexp(0, (value - threshold) / width) - at_rest)
