"""A thick rubber hull all around its chamber, bent by pressure: the pressure that holds a
curvature.

The base model has one wall on top at the strain of the outer face, and a factor for the side walls
(eq. 3.35). Here all rubber of the section counts, including side walls and passive layer, at its
own place. In a section of constant outer size, pressure does the work p*z*h**2/2 per curvature (eq.
3.17), whatever happens in the rubber. So p = 2/(z*h**2)*dU/dkappa with U the elastic energy per
length of the passive layer [J/m].
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.optimize import brentq

from softhand_model.hand.actuator import Actuator
from thesis.frame import Array

RADII, ANGLES = 24, 24  # points of the integral over the ring
NEWTON_STEPS = 8
DIFFERENCE = 1e-4  # of kappa*h, on either side
HIGHEST = 12.0  # kappa*h up to which a curvature is sought


@dataclass(frozen=True)
class Rubber:
    """Yeoh's law with two terms: modulus [Pa], and c2 [-] as in `yeoh_stiffening`; c2 = 0 is
    neo-Hookean.
    """

    modulus: float
    c2: float = 0.0

    def energy(self, invariant: Array) -> Array:
        """Energy per volume [Pa] at an invariant J1 [-]."""
        return np.asarray(self.modulus / 2.0 * (invariant + self.c2 * invariant**2))


@dataclass(frozen=True)
class Hull:
    """A square section: outer height [m], wall [m] on top and at both sides, and rubber of the
    passive layer above its mesh, floor [m].
    """

    height: float
    wall: float
    floor: float

    @property
    def chamber(self) -> float:
        """Area [m2] of the chamber."""
        return (self.height - 2.0 * self.wall) * (self.height - self.wall - self.floor)

    @property
    def outer_radius(self) -> float:
        """Radius [m] of the ring that has the section's area."""
        return self.height / np.sqrt(np.pi)

    @property
    def inner_radius(self) -> float:
        """Radius [m] of the circle that has the chamber's area."""
        return float(np.sqrt(self.chamber / np.pi))

    def layered_pressure(self, curvature: float, modulus: float) -> float:
        """Pressure [Pa] if every part of a neo-Hookean section keeps its depth and is in pure
        shear: the integral of y*q(1 + kappa*y) over the section.
        """
        h, d, t = self.height, self.wall, self.floor
        top, sides, floor = (
            (h, h - d, h),
            (h - d, t, 2.0 * d),
            (t, 0.0, h),
        )
        moment = sum(
            width * (_lever(curvature, high) - _lever(curvature, low))
            for high, low, width in (top, sides, floor)
        )
        return float(2.0 * modulus * moment / h**3)

    def ring_pressure(self, curvature: float, rubber: Rubber) -> float:
        """Pressure [Pa] if the rubber moves outwards as it thins, within the thread: the section as
        a ring of the same areas.
        """
        step = DIFFERENCE / self.height
        rise = self.ring_energy(curvature + step, rubber) - self.ring_energy(
            curvature - step, rubber
        )
        return float(2.0 * rise / (2.0 * step) / self.height**3)

    def ring_energy(self, curvature: float, rubber: Rubber) -> float:
        """Elastic energy [J/m] of the ring at a curvature [1/m]."""
        radius, angle, area = self._points()
        invariant = ring_invariant(curvature, radius, angle, self.outer_radius, self.height / 2.0)
        return float(np.sum(area * rubber.energy(invariant)))

    def ring_curvature(self, pressure: float, rubber: Rubber) -> float:
        """Curvature [1/m] at a pressure [Pa]."""
        return float(
            brentq(
                lambda kappa: self.ring_pressure(kappa, rubber) - pressure,
                0.0,
                HIGHEST / self.height,
            )
        )

    def _points(self) -> tuple[Array, Array, Array]:
        """Radius [m] and angle [rad] of points of the straight ring, and the area [m2] of each."""
        place, weight = np.polynomial.legendre.leggauss(RADII)
        half = (self.outer_radius - self.inner_radius) / 2.0
        radius = self.inner_radius + half * (place + 1.0)
        angle = (np.arange(ANGLES) + 0.5) / ANGLES * 2.0 * np.pi
        return radius[:, None], angle, (radius * weight * half)[:, None] * 2.0 * np.pi / ANGLES


def ring_invariant(
    curvature: float, radius: Array, angle: Array, outer_radius: float, middle: float
) -> Array:
    """Invariant J1 [-], at a curvature [1/m], of rubber that lay at a radius [m] and an angle [rad]
    (from sideways) around the chamber, whose centre is `middle` [m] above the mesh.

    The thread keeps the outer radius [m] constant, and rubber keeps its volume while it moves along
    its own radius. As in section 3.4.5, the passive layer is taken as the centre of the circles.
    """
    along, slope = 1.0 + curvature * middle, curvature * np.sin(angle)
    moved = radius + 0.0 * angle
    for _ in range(NEWTON_STEPS):
        excess = (
            along * (outer_radius**2 - moved**2) / 2.0
            + slope * (outer_radius**3 - moved**3) / 3.0
            - (outer_radius**2 - radius**2) / 2.0
        )
        moved = np.clip(moved + excess / (moved * (along + slope * moved)), radius, outer_radius)
    axial, around = along + slope * moved, moved / radius
    return np.asarray(axial**2 + around**2 + (axial * around) ** -2.0 - 3.0)


def _lever(curvature: float, depth: float) -> float:
    """Integral of y*q(1 + kappa*y) from the mesh up to a depth [m] (see `section.side_wall_term`).

    >>> _lever(0.0, 1.0)
    0.0
    """
    bent = depth**2 / (2.0 * (1.0 + curvature * depth) ** 2)
    return depth**2 / 2.0 + curvature * depth**3 / 3.0 - bent


def hull_of(actuator: Actuator, floor: float) -> Hull:
    """The hull of an even actuator, with a passive layer of `floor` [m]."""
    return Hull(float(actuator.height(0.0)), float(actuator.wall(0.0)), floor)
