"""The palm sheet: a sheet of silicone bent to an arch that deflects under load (7.2, 7.3).

The arch stands on both clamped edges, a beam of the sheet's section bent to a circle. Pressed in
the middle it keeps its length and the angles at its clamps; half of it carries the moment

    M(phi) = M_0 + H*R*(1 - cos phi) - P/2*R*sin phi,      phi from the crown,

and M_0, H follow from crown and clamps that neither turn nor shift sideways. The thesis gives size
and modulus of the sheet of RBO Hand 1, and no stiffness; the arch is ours, linear and for small
loads.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from softhand_common.numerics.arrays import Array

ARCH_GAUSS_POINTS = 24


@dataclass(frozen=True)
class PalmSheet:
    """A sheet with length (along which it is bent), width and thickness [m] and Young's modulus
    [Pa], bent by `angle` [rad] over its whole length.

    position (3,) [m] and rpy (3,) [rad]: of its frame in that of the wrist. The origin lies in the
    middle between the clamped edges, z along that line, y along the width, and the arch rises
    towards x.
    """

    length: float
    width: float
    thickness: float
    modulus: float
    angle: float
    position: tuple[float, ...]
    rpy: tuple[float, ...]

    @property
    def radius(self) -> float:
        """Radius [m] of the arch."""
        return self.length / self.angle

    @property
    def rise(self) -> float:
        """Height [m] of the crown above the clamped edges."""
        return self.radius * (1.0 - float(np.cos(self.angle / 2.0)))

    def stiffness(self) -> float:
        """Stiffness of the crown line [N/m]: force over deflection.

        >>> sheet = PalmSheet(0.1, 0.08, 0.005, 600e3, np.pi, (0, 0, 0), (0, 0, 0))
        >>> round(sheet.stiffness())
        1329
        """
        inertia = self.width * self.thickness**3 / 12.0
        return self.modulus * inertia / (self.radius**3 * arch_compliance(self.angle))

    def profile(self, points: int) -> Array:
        """Points (points, 2) [m] of the arch in its frame: x (height) and z."""
        heading = np.linspace(-0.5, 0.5, points) * self.angle
        base = np.cos(self.angle / 2.0)
        return self.radius * np.stack([np.cos(heading) - base, np.sin(heading)], axis=1)


def arch_compliance(angle: float) -> float:
    """Deflection of the crown of a clamped inextensible circular arch in units of P*R**3/(E*I) [-].

    Args:
        angle: of the whole arch [rad], at most pi.

    >>> round(arch_compliance(np.pi), 5)
    0.01166
    """
    nodes, weights = np.polynomial.legendre.leggauss(ARCH_GAUSS_POINTS)
    phi, weight = angle / 4.0 * (nodes + 1.0), angle / 4.0 * weights
    free = np.stack([np.ones_like(phi), 1.0 - np.cos(phi)])
    loaded = -np.sin(phi) / 2.0
    unknown = np.linalg.solve((free * weight) @ free.T, -(free * weight) @ loaded)
    moment = unknown @ free + loaded
    return float(2.0 * np.sum(weight * moment**2))
