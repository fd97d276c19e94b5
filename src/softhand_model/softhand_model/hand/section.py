"""Bending of one rectangular section of a PneuFlex actuator: pressure, moment, stretch, curvature,
volume.

All functions take numbers or arrays that broadcast, in SI units. Symbols of the thesis (R. Deimel,
Soft Robotic Hands For Compliant Grasping, chapter 3): height h [m], width z [m], wall d [m] on top,
side_wall [m] of each of the two side walls, shear_modulus G [Pa], pressure p [Pa] (gauge),
curvature kappa [1/m] of the passive layer, and the stretch lambda = 1 + kappa*h [-] of the top.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from softhand_common.numerics.arrays import Array
from softhand_common.numerics.compiled import compiled

SECTION_NEWTON_STEPS = 60  # the slowest start (load near 1) needs 8; the rest is a guard
PRINTED_SLOPE_RATIO = 4.0  # a of eq. 5.5
PRINTED_TRANSITION = 0.90  # factor of p0 in eq. 5.6


def arrays(*values: ArrayLike) -> tuple[Array, ...]:
    """Numbers or sequences as arrays of floats."""
    return tuple(np.asarray(value, float) for value in values)


def elastic_term(stretch: ArrayLike) -> Array:
    """Neo-Hookean pure shear, q = lambda - lambda**-3 [-] (eq. 3.21).

    >>> round(float(elastic_term(3.0)), 4)
    2.963
    """
    stretch = np.asarray(stretch, float)
    return stretch - stretch**-3.0


def side_wall_ratio(
    height: ArrayLike, width: ArrayLike, wall: ArrayLike, side_wall: ArrayLike
) -> Array:
    """Factor `ratio` [-] by which the side walls change the actuation ratio of eq. 3.32 (eq. 3.35).

    2/ratio is the elastic energy with side walls over that of the top wall alone; without side
    walls ratio is 2. The base model puts this one factor on load and stiffness alike. ERRATUM: 3.35
    prints the factor (d_l + d_r)/(2*d) outside the fraction; 3.36 is the case z = h. ERRATUM: the
    "common case z = d" of the text, in which the ratio is 1 for thin walls, must read z = h. A wall
    thicker than the height leaves no side walls.

    >>> round(float(side_wall_ratio(0.02, 0.02, 0.002, 0.002)), 3)
    1.105
    """
    height, width, wall, side_wall = arrays(height, width, wall, side_wall)
    inner = np.maximum(height - wall, 0.0)
    return 2.0 / (1.0 + inner**2 / (height * width) * side_wall / wall)


def bending_load(
    pressure: ArrayLike,
    height: ArrayLike,
    wall: ArrayLike,
    ratio: ArrayLike,
    shear_modulus: ArrayLike,
) -> Array:
    """Load s = p*ratio*h/(4*G*d) [-] in free bending (thesis, eq. 3.30 with 3.37): that of the
    pressure p [Pa] on a section of height h [m] with a wall of thickness d [m] and shear modulus
    G [Pa]. `ratio` [-]: of `side_wall_ratio`.

    >>> float(bending_load(67e3, 0.02, 0.002, 1.0, 67e3))
    2.5
    """
    pressure, height, wall, ratio = arrays(pressure, height, wall, ratio)
    return pressure * ratio * height / (4.0 * np.asarray(shear_modulus, float) * wall)


def free_stretch(load: ArrayLike) -> Array:
    """Stretch lambda [-] with lambda - lambda**-3 = load: the positive root of lambda**4 -
    s*lambda**3 - 1 = 0.

    The thesis calls the exact solution convoluted and uses eq. 5.3 instead; Newton from max(1, s)
    has it in a few steps to machine precision. A negative load gives a stretch below 1.

    >>> round(float(free_stretch(3.0 - 3.0**-3)), 12)
    3.0
    """
    s = np.asarray(load, float)
    stretch = np.maximum(1.0, s)
    for _ in range(SECTION_NEWTON_STEPS):
        # the quartic over lambda**2, so that large loads stay in range
        step = (stretch * (stretch - s) - stretch**-2.0) / (4.0 * stretch - 3.0 * s)
        stretch = stretch - step
        if np.all(np.abs(step) <= 1e-15 * stretch):
            break
    return stretch


def free_curvature(
    pressure: ArrayLike,
    height: ArrayLike,
    width: ArrayLike,
    wall: ArrayLike,
    side_wall: ArrayLike,
    shear_modulus: ArrayLike,
) -> Array:
    """Curvature [1/m] of an unloaded section at a pressure, exact: kappa = (lambda - 1)/h (eq.
    3.12, 3.30-3.37). pressure is in [Pa], sizes in [m], shear_modulus in [Pa].

    >>> kappa = free_curvature(31e3, 0.02, 0.02, 0.002, 0.002, 73.7e3)
    >>> round(float(np.degrees(kappa * 0.09)), 1)
    122.2
    """
    ratio = side_wall_ratio(height, width, wall, side_wall)
    stretch = free_stretch(bending_load(pressure, height, wall, ratio, shear_modulus))
    return (stretch - 1.0) / np.asarray(height, float)


def printed_nonlinearity(
    relative_pressure: ArrayLike,
    slope_ratio: float = PRINTED_SLOPE_RATIO,
    transition: float = PRINTED_TRANSITION,
) -> Array:
    """Secant actuation ratio over that of the rule 3.32, as approximated by eq. 5.3 [-].

    relative_pressure is u = p*h/(8*G*d) [-], slope_ratio is a and transition p0*h/(8*G*d). ERRATUM:
    5.6 prints p0 with a minus sign, which has no effect because p0 enters squared. Against the
    exact secant (ratio = 1) it errs by +8.4 % at u = 0.3, -1.2 % at 1.5 and +12 % at 5; its limit
    is 1/2 + sqrt(3) = 2.23, not 2.

    >>> float(printed_nonlinearity(0.0))
    0.5
    """
    u = np.asarray(relative_pressure, float)
    below = np.sqrt(u**2 / (slope_ratio - 1.0) + (slope_ratio - 1.0) * transition**2)
    return 1.0 / np.sqrt(slope_ratio) + u / below


def free_curvature_printed(
    pressure: ArrayLike,
    height: ArrayLike,
    width: ArrayLike,
    wall: ArrayLike,
    side_wall: ArrayLike,
    shear_modulus: ArrayLike,
) -> Array:
    """Curvature [1/m] of an unloaded section by the approximation of the thesis (eq. 5.2, 5.3,
    5.6). Units as for `free_curvature`.

    >>> kappa = free_curvature_printed(31e3, 0.02, 0.02, 0.002, 0.002, 73.7e3)
    >>> round(float(np.degrees(kappa * 0.09)), 1)
    124.5
    """
    rule = np.asarray(pressure, float) * rule_actuation_ratio(wall, shear_modulus)
    ratio = side_wall_ratio(height, width, wall, side_wall)
    return rule * ratio * printed_nonlinearity(rule * np.asarray(height, float))


def rule_actuation_ratio(wall: ArrayLike, shear_modulus: ArrayLike) -> Array:
    """Actuation ratio dkappa/dp = 1/(8*G*d) [1/(m Pa)] of the design rule (eq. 3.32); wall in [m],
    shear_modulus in [Pa].
    """
    return 1.0 / (8.0 * np.asarray(shear_modulus, float) * np.asarray(wall, float))


def bending_moment(
    pressure: ArrayLike,
    curvature: ArrayLike,
    height: ArrayLike,
    width: ArrayLike,
    wall: ArrayLike,
    side_wall: ArrayLike,
    shear_modulus: ArrayLike,
) -> Array:
    """External moment [N m] that holds a section at a curvature; positive straightens (section
    3.4.3). curvature is in [1/m], other units as for `free_curvature`.

    M = h**2*z*p/2 - (2/ratio)*G*h*d*z*q(lambda). ERRATUM: the text prints a minus before the
    pressure term, against eq. 3.23. A straight section carries h**2*z*p/2 whatever G, d and side
    walls; at the free curvature M is 0.

    >>> round(float(bending_moment(50e3, 0.0, 0.02, 0.02, 0.002, 0.002, 67e3)), 9)
    0.2
    """
    height, width, wall = arrays(height, width, wall)
    pressure, curvature, modulus = arrays(pressure, curvature, shear_modulus)
    elastic = elastic_term(1.0 + curvature * height)
    walls = 2.0 / side_wall_ratio(height, width, wall, side_wall)
    return height**2 * width * pressure / 2.0 - walls * modulus * height * wall * width * elastic


def bending_stiffness(
    curvature: ArrayLike,
    height: ArrayLike,
    width: ArrayLike,
    wall: ArrayLike,
    side_wall: ArrayLike,
    shear_modulus: ArrayLike,
) -> Array:
    """Tangent stiffness B = -dM/dkappa = (2/ratio)*h**2*z*G*d*(1 + 3*lambda**-4) [N m2] (eq. 3.24).
    Units as for `bending_moment`.

    ERRATUM: eq. 3.27 has two lengths and 3.28 one length too many, and the share of the side walls
    of 3.29 contradicts that of 3.36; the base model uses 2/ratio of 3.35 for both. See
    `printed_side_wall_share` for 3.29.

    >>> round(float(bending_stiffness(0.0, 0.02, 0.02, 0.002, 0.0, 67e3) * 1e3), 3)
    4.288
    """
    height, width, wall = arrays(height, width, wall)
    curvature, modulus = arrays(curvature, shear_modulus)
    stretch = 1.0 + curvature * height
    walls = 2.0 / side_wall_ratio(height, width, wall, side_wall)
    return walls * height**2 * width * modulus * wall * (1.0 + 3.0 * stretch**-4.0)


def rule_stiffness(edge: ArrayLike, wall: ArrayLike, shear_modulus: ArrayLike) -> Array:
    """Stiffness B = 2*edge**3*G*d [N m2] of the design rule, edge = h (eq. 3.25) or a quarter
    circumference (3.26). Sizes are in [m], shear_modulus in [Pa].

    ERRATUM: the text has it reversed; the rule underestimates the tangent stiffness by 2 at zero
    curvature and overestimates it by 2 at large curvature.

    >>> round(float(rule_stiffness(0.02, 0.002, 67e3) * 1e3), 3)
    2.144
    """
    edge, wall, shear_modulus = arrays(edge, wall, shear_modulus)
    return 2.0 * edge**3 * shear_modulus * wall


def printed_side_wall_share(height: ArrayLike, wall: ArrayLike, side_wall: ArrayLike) -> Array:
    """Stiffness of both side walls over that of eq. 3.26 [-], as printed in eq. 3.29 (the base
    model does not use it).

    >>> round(float(printed_side_wall_share(1.0, 0.1, 0.1)), 3)
    0.328
    """
    height, wall = np.asarray(height, float), np.asarray(wall, float)
    inner = np.maximum(height - wall, 0.0) / height
    return 0.25 * inner**4 * 2.0 * np.asarray(side_wall, float) / wall


def side_wall_share(
    height: ArrayLike, width: ArrayLike, wall: ArrayLike, side_wall: ArrayLike
) -> Array:
    """Stiffness of both side walls over that of the top wall at zero curvature [-]: from the exact
    integral of eq. 3.27.

    >>> round(float(side_wall_share(1.0, 1.0, 0.1, 0.1)), 3)
    0.486
    """
    height, width, wall, side_wall = arrays(height, width, wall, side_wall)
    inner = np.maximum(height - wall, 0.0) / height
    return inner**3 / 3.0 * 2.0 * side_wall / wall * height / width


def side_wall_term(
    curvature: ArrayLike, height: ArrayLike, width: ArrayLike, wall: ArrayLike, side_wall: ArrayLike
) -> Array:
    """Contribution of the side walls, `term` in p*h/(2*G*d) = q(lambda) + term [-], integrated
    exactly over their height.

    ERRATUM: 3.34 drops a factor y/h. With Y = h - d the integral of y*q(1 + kappa*y) dy is
    Y**2/2 + kappa*Y**3/3 - Y**2/(2*(1 + kappa*Y)**2).
    """
    height, width, wall, side_wall = arrays(height, width, wall, side_wall)
    curvature, inner = np.asarray(curvature, float), np.maximum(height - wall, 0.0)
    integral = side_wall_integral.py_func(curvature, inner)
    return np.asarray(2.0 * side_wall / (height * width * wall) * integral)


@compiled
def side_wall_integral(curvature: Any, inner: Any) -> Any:
    """Integral [m2] of y*q(1 + kappa*y) over the inner height Y [m]."""
    bent = inner**2 / (2.0 * (1.0 + curvature * inner) ** 2)
    return inner**2 / 2.0 + curvature * inner**3 / 3.0 - bent


def small_strain_side_wall_ratio(
    height: ArrayLike, width: ArrayLike, wall: ArrayLike, side_wall: ArrayLike
) -> Array:
    """The ratio of `side_wall_ratio` from the exact integral at small strain [-] (ERRATUM of eq.
    3.34).

    >>> round(float(small_strain_side_wall_ratio(1.0, 1.0, 0.1, 0.1)), 3)
    1.346
    """
    return 2.0 / (1.0 + side_wall_share(height, width, wall, side_wall))


def chamber_area(
    curvature: ArrayLike,
    height: ArrayLike,
    width: ArrayLike,
    wall: ArrayLike,
    side_wall: ArrayLike = 0.0,
) -> Array:
    """Air volume per length of the passive layer [m2]: z*h*(1 + h*kappa/2) less the rubber (eq.
    3.15-3.17).

    The rubber is z*d of the top and, for the contained mass, (h - d)*2*side_wall of the side walls;
    it keeps its volume, so dV/dkappa = z*h**2/2 with and without it.

    >>> round(float(chamber_area(0.0, 9e-3, 9e-3, 3e-3) * 0.12 * 1e6), 2)
    6.48
    """
    height, width, wall = arrays(height, width, wall)
    rubber = width * wall + np.maximum(height - wall, 0.0) * 2.0 * np.asarray(side_wall, float)
    return width * height * (1.0 + height * np.asarray(curvature, float) / 2.0) - rubber
