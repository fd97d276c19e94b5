"""Elastic laws: nominal stress over shear modulus as a function of stretch.

Mode `planar` is the wall of a bending actuator (the width is held by the fibres), `uniaxial` a
strip that is pulled. Every law has slope 4 (planar) or 3 (uniaxial) at rest, as the base law has.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

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
