"""Families outside of the catalogue that are kept for blind runs, see `bench.hidden.reserved`.

Sizes are shares of the largest output.
"""

from __future__ import annotations

import numpy as np

from bench.hidden.laws.registry import law
from bench.hidden.plant import Plant

Array = np.ndarray


@law(
    "eccentric_encoder",
    ("size", 0.001, 0.4),
    lambda rng: {"turns": rng.uniform(2.0, 4.0), "phase": rng.uniform(0.0, 2 * np.pi)},
)
def eccentric_encoder(plant: Plant, size: float, turns: float, phase: float) -> None:
    """An encoder whose disc runs out of true: an error that is periodic in what it reads."""

    def shown(t: Array, y: Array, p: Array) -> Array:
        full = np.abs(y).max()
        around = 2 * np.pi * turns * y / full + phase
        return y + size * full * (np.sin(around) - np.sin(phase))

    plant.sensors.append(shown)


@law("stick_slip", ("width", 0.004, 0.6))
def stick_slip(plant: Plant, width: float) -> None:
    """A finger that sticks to what it lies on until it is pulled far enough, and then jumps."""
    plant.moving = True

    def shown(t: Array, y: Array, p: Array) -> Array:
        out, held = y.copy(), y[:, 0].copy()
        reach = width * np.abs(y).max()
        for k in range(y.shape[1]):
            held = np.where(np.abs(y[:, k] - held) > reach, y[:, k], held)
            out[:, k] = held
        return out

    plant.sensors.append(shown)


@law("day_cycle", ("size", 0.002, 0.6), lambda rng: {"cycles": rng.uniform(1.3, 2.3)}, True)
def day_cycle(plant: Plant, size: float, cycles: float) -> None:
    """The gain of the reading follows the heating of the room over the session."""

    def shown(t: Array, y: Array, p: Array) -> Array:
        spent = np.concatenate([[0.0], np.cumsum(t[:, -1] - t[:, 0])])
        session = (spent[:-1, None] + t - t[:, :1]) / spent[-1]
        return y * (1 + size * np.sin(2 * np.pi * cycles * session))

    plant.sensors.append(shown)


@law("wobbling_clock", ("size", 0.003, 2.0), lambda rng: {"frequency": rng.uniform(0.15, 0.4)})
def wobbling_clock(plant: Plant, size: float, frequency: float) -> None:
    """Time stamps that run ahead and behind periodically, by `size` [s]."""
    plant.moving = True

    def shown(t: Array, y: Array, p: Array) -> Array:
        wrong = t + size * np.sin(2 * np.pi * frequency * (t - t[:, :1]))
        return np.array([np.interp(then, a, b) for then, a, b in zip(wrong, t, y, strict=True)])

    plant.sensors.append(shown)


@law(
    "touched",
    ("size", 0.003, 0.8),
    lambda rng: {"first": rng.uniform(0.2, 0.4), "second": rng.uniform(0.55, 0.8)},
    True,
)
def touched(plant: Plant, size: float, first: float, second: float) -> None:
    """A cable leans on the finger twice in every run, at the same shares of its time."""

    def shown(t: Array, y: Array, p: Array) -> Array:
        share = (t - t[:, :1]) / (t[:, -1:] - t[:, :1])
        pushed = sum(np.exp(-(((share - at) / 0.04) ** 2)) for at in (first, second))
        return y + size * np.abs(y).max() * pushed

    plant.sensors.append(shown)


@law(
    "chatter",
    ("size", 0.003, 0.6),
    lambda rng: {"low": rng.uniform(0.35, 0.45), "period": rng.uniform(0.9, 1.6)},
)
def chatter(plant: Plant, size: float, low: float, period: float) -> None:
    """A valve that chatters between two pressures: a square wave there, nothing elsewhere."""

    def shown(t: Array, y: Array, p: Array) -> Array:
        inside = (p > low * p.max()) & (p < (low + 0.3) * p.max())
        wave = np.sign(np.sin(2 * np.pi * (t - t[:, :1]) / period))
        return y + size * np.abs(y).max() * wave * inside

    plant.sensors.append(shown)
