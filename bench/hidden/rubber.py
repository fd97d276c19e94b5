"""Elastic laws: nominal stress over shear modulus as a function of stretch.

Mode `planar` is the wall of a bending actuator (the width is held by the fibres), `uniaxial` a
strip that is pulled. Every law has slope 4 (planar) or 3 (uniaxial) at rest, as the base law has.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
from scipy.special import erf

Array = np.ndarray
Law = Callable[[Array], Array]

CHAIN_SERIES = (1 / 2, 1 / 20, 11 / 1050, 19 / 7000, 519 / 673750)  # of the inverse Langevin


def neo_hooke(stretch: Array, mode: str = "planar") -> Array:
    """The base law."""
    return stretch - stretch ** (-3.0 if mode == "planar" else -2.0)


def first_invariant(stretch: Array, mode: str = "planar") -> Array:
    """I1 - 3."""
    if mode == "planar":
        return stretch**2 + stretch**-2.0 - 2.0
    return stretch**2 + 2.0 / stretch - 3.0


def gent(stretch: Array, mode: str, jm: float) -> Array:
    """Factor of Gent's law; beyond its pole it stays steep, so that a root always exists."""
    used = first_invariant(stretch, mode) / jm
    return 1.0 / np.where(used < 0.999, 1.0 - used, 1e-3 / (1.0 + 1e3 * (used - 0.999)))


def yeoh(stretch: Array, mode: str, c2: float) -> Array:
    """Factor of a two-term Yeoh law."""
    return 1.0 + 2.0 * c2 * first_invariant(stretch, mode)


def mooney_rivlin(stretch: Array, mode: str, c01_ratio: float) -> Array:
    """Factor of Mooney-Rivlin; one in the planar mode, where both invariants agree."""
    return 1.0 if mode == "planar" else (1.0 + c01_ratio / stretch) / (1.0 + c01_ratio)


def fung(stretch: Array, mode: str, b: float) -> Array:
    """Factor of an exponential law."""
    return np.exp(np.minimum(b * first_invariant(stretch, mode), 50.0))


def arruda_boyce(stretch: Array, mode: str, links: float) -> Array:
    """Factor of the eight-chain law, five terms, one at rest."""

    def slope(i1: Array) -> Array:
        terms = enumerate(CHAIN_SERIES)
        return sum((k + 1) * c * i1**k / links**k for k, c in terms)

    return slope(first_invariant(stretch, mode) + 3.0) / slope(3.0)


def ogden(stretch: Array, mode: str, share: float, exponent: float) -> Array:
    """Factor of a two-term Ogden law: exponents 2 and `exponent`, `share` of G in the second."""
    other = exponent if mode == "planar" else exponent / 2.0
    stress = 2.0 / exponent * (stretch ** (exponent - 1.0) - stretch ** (-other - 1.0))
    base = neo_hooke(stretch, mode)
    near = np.abs(stretch - 1.0) < 1e-7
    ratio = np.where(near, 1.0, stress / np.where(near, 1.0, base))
    return 1.0 - share + share * ratio


def thick_wall(stretch: Array, wall_over_height: Array, gain: float) -> Array:
    """Factor of a wall that is stiffer near its rest shape."""
    share = np.minimum(2.0 * wall_over_height, 1.0) ** 2
    return 1.0 + gain * share * np.exp(-(stretch - 1.0) / 0.25)


def thick_wall_rational(stretch: Array, wall_over_height: Array, gain: float) -> Array:
    """The same with another decay."""
    share = np.minimum(2.0 * wall_over_height, 1.0) ** 2
    return 1.0 + gain * share / (1.0 + np.maximum((stretch - 1.0) / 0.22, -0.5)) ** 2


def side_wall_stress(
    stretch: Array, height: Array, width: Array, wall: Array, side: Array
) -> Array:
    """Stress of both side walls over that of the top wall's unit, integrated over their height."""
    reach = np.maximum(height - wall, 0.0)
    kappa = (stretch - 1.0) / height
    inner = reach**2 / 2 + kappa * reach**3 / 3 - reach**2 / (2 * (1 + kappa * reach) ** 2)
    return 2.0 * side / (height * width * wall) * inner


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
