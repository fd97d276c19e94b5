"""What rubber remembers: relaxing modes, friction-like loops, softening by the largest stretch.

Each has `trial(...)` (a value at a trial stretch, memory untouched) and `commit(...)`. Modes use
the trapezoidal rule, loops the midpoint rule in the stretch: second order on a grid several times
finer than the samples.
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
        half = dt / (2 * np.reshape(self.tau, (-1, *ones)))
        jump = np.reshape(self.g, (-1, *ones)) * (stress - self.last)
        return (self.nu * (1 - half) + jump) / (1 + half)

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
        half = np.abs(change) / (2 * self.scale)
        return (self.w * (1 - half) + change / self.scale) / (1 + half)

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
        w = self.w
        for _ in range(2):
            middle = (self.w + w) / 2
            turn = self.beta * np.sign(change * middle) + 1 - self.beta
            w = self.w + change * (1 - np.abs(middle) ** self.exponent * turn)
        return w


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
