"""What rubber remembers: relaxing modes, friction-like loops, softening by the largest stretch.

Each has `trial(...)` (a value at a trial stretch, memory untouched) and `commit(...)`. Steps are
exact for a stress (or stretch) that is straight within the step, on a grid several times finer than
the samples; the Bouc-Wen loop uses the midpoint rule.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from scipy.special import erf

Array = np.ndarray


@dataclass
class Modes:
    """Maxwell modes: nu' = -nu/tau + g*Q' each, on top of the relaxed stress Q."""

    g: Array
    tau: Array
    nu: Array = field(default_factory=lambda: np.zeros(1))
    last: Array | float = 0.0

    def reset(self, shape: tuple[int, ...]) -> None:
        """Nothing remembered."""
        self.nu, self.last = np.zeros((len(self.g), *shape)), np.zeros(shape)

    def _next(self, stress: Array, dt: Array) -> Array:
        ones = (1,) * stress.ndim
        part = dt / np.reshape(self.tau, (-1, *ones))
        jump = np.reshape(self.g, (-1, *ones)) * (stress - self.last)
        mean = np.where(part > 1e-9, -np.expm1(-part) / np.maximum(part, 1e-12), 1.0)
        return self.nu * np.exp(-part) + jump * mean

    def trial(self, stress: Array, dt: Array) -> Array:
        """Sum of the modes if Q were `stress` at the end of the step."""
        return self._next(stress, dt).sum(axis=0)

    def commit(self, stress: Array, dt: Array) -> None:
        """Take the step."""
        self.nu, self.last = self._next(stress, dt), stress


@dataclass
class Loop:
    """s_c*w with dw = (sign(dlam) - w)*abs(dlam)/scale."""

    strength: float
    scale: float
    w: Array | float = 0.0
    last: Array | float = 1.0

    def reset(self, shape: tuple[int, ...]) -> None:
        """Nothing remembered."""
        self.w, self.last = np.zeros(shape), np.ones(shape)

    def _next(self, stretch: Array) -> Array:
        change = stretch - self.last
        turn = np.sign(change)
        return turn + (self.w - turn) * np.exp(-np.abs(change) / self.scale)

    def trial(self, stretch: Array) -> Array:
        """Stress at a trial stretch."""
        return self.strength * self._next(stretch)

    def commit(self, stretch: Array) -> None:
        """Take the step."""
        self.w, self.last = self._next(stretch), stretch


@dataclass
class BoucWen(Loop):
    """dw = dlam/scale*(1 - abs(w)**n*(beta*sign(dlam*w) + 1 - beta))."""

    exponent: float = 1.6
    beta: float = 0.7

    def _next(self, stretch: Array) -> Array:
        change = (stretch - self.last) / self.scale
        parts = int(np.clip(np.ceil(np.max(np.abs(change)) / 0.25), 1, 40))
        change, w = change / parts, self.w
        for _ in range(parts):
            middle = w + change / 2 * self._slope(change, w)
            w = w + change * self._slope(change, middle)
        return w

    def _slope(self, change: Array, w: Array) -> Array:
        turn = self.beta * np.sign(change * w) + 1 - self.beta
        return 1 - np.minimum(np.abs(w), 2.0) ** self.exponent * turn


@dataclass
class Plays:
    """Prandtl-Ishlinskii: several elastic-slip elements side by side, widths around the scale."""

    strength: float
    scale: float
    widths: Array = field(default_factory=lambda: np.array([0.3, 0.7, 1.2, 2.0, 3.2]))
    shares: Array = field(default_factory=lambda: np.array([0.28, 0.26, 0.2, 0.16, 0.1]))
    slips: Array = field(default_factory=lambda: np.zeros(1))
    last: Array | float = 1.0

    def reset(self, shape: tuple[int, ...]) -> None:
        """Nothing remembered."""
        self.slips, self.last = np.zeros((5, *shape)), np.ones(shape)

    def _next(self, stretch: Array) -> Array:
        width = (self.widths * self.scale).reshape(-1, *(1,) * stretch.ndim)
        return np.clip(self.slips + (stretch - self.last) / width, -1.0, 1.0)

    def trial(self, stretch: Array) -> Array:
        """Stress at a trial stretch."""
        return self.strength * np.tensordot(self.shares, self._next(stretch), 1)

    def commit(self, stretch: Array) -> None:
        """Take the step."""
        self.slips, self.last = self._next(stretch), stretch


@dataclass
class Softening:
    """Factor below the largest stretch so far: 1 - softening*(1 - exp(-(largest-lam)/scale))."""

    softening: float
    stretch_scale: float
    largest: Array | float = 1.0

    def factor(self, stretch: Array) -> Array:
        """Factor at a trial stretch."""
        below = np.maximum(self.largest - stretch, 0.0)
        return 1 - self.softening * (1 - np.exp(-below / self.stretch_scale))

    def commit(self, stretch: Array) -> None:
        """Take the step."""
        self.largest = np.maximum(self.largest, stretch)


@dataclass
class OgdenRoxburgh:
    """Factor 1 - erf((W_max - W)/(m + beta*W_max))/r, W the neo-Hookean energy over G."""

    inverse_r: float
    m: float
    beta: float = 0.1
    largest: Array | float = 1.0

    @staticmethod
    def _energy(stretch: Array) -> Array:
        return 0.5 * (stretch**2 + stretch**-2.0 - 2.0)

    def factor(self, stretch: Array) -> Array:
        """Factor at a trial stretch."""
        most = self._energy(np.maximum(self.largest, stretch))
        return 1 - self.inverse_r * erf(
            (most - self._energy(stretch)) / (self.m + self.beta * most)
        )

    def commit(self, stretch: Array) -> None:
        """Take the step."""
        self.largest = np.maximum(self.largest, stretch)
