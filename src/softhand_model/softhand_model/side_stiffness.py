"""Stiffness of an actuator sideways and in twist, from its section; the thesis has no model of it
and sets both equal to that in bending, "as a very crude approximation" (section 5.2.4).

The section is that of chapter 3: height h, width z, a top wall of thickness d, two side walls, and
below them the passive layer, a mesh in rubber.

Lateral bending (about the height) strains the walls along the actuator while the thread keeps them
from straining around it, as in bending. So the modulus is the tangent of eq. 3.21, G*(1 +
3*lambda**-4), for which the rule 3.25 takes 2*G: B_lateral = 2*G*I, I the second moment of the
walls about the plane in their middle. The passive layer counts for nothing: a mesh bears no
compression.

Twist shears the walls. Neo-Hookean rubber has the nominal shear stress G*gamma whatever its
stretch, and one shear flow runs around the closed section: B_twist = G*J with Bredt's J =
4*A**2/integral(ds/t) along the middle of the walls. The passive layer counts as rubber as thick as
the top wall; its mesh shears freely.

Limits. Lateral: 2*G*I is a lower bound. A mesh that does not stretch is taut by half of the
pressure's force on the section, h*z*p/2, up to a moment of h*z**2*p/4, below which it would not
give way at all; beyond that the actuator turns about the edge that stays taut, where I is 2.3 times
as large (thin walls, h = z). Twist: a passive layer that does not shear makes J at most 4/3 as
large (h = z, all walls alike), a layer that shears without resistance leaves an open section with
next to none. Pressure: a section that turns about the middle of the passive layer keeps its area,
so it does no work; the mesh's tension adds h*z**3*p/24, the tension of the rubber at most half of
J. Thread: a single helix couples twist to pressure and to lateral bending (`bend_twist_coupling`),
thread wound both ways stiffens against twist. None of these is counted.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]


def lateral_second_moment(
    height: ArrayLike, width: ArrayLike, wall: ArrayLike, side_wall: ArrayLike
) -> Array:
    """Second moment [m4] of top and side walls about the plane in the middle of the width.

    >>> round(float(lateral_second_moment(0.02, 0.02, 0.002, 0.002)) * 1e9, 3)
    7.189
    """
    height, width, wall, side_wall = _arrays(height, width, wall, side_wall)
    inner = np.maximum(height - wall, 0.0)
    off_middle = (width - side_wall) / 2.0
    of_sides = 2.0 * inner * side_wall * (side_wall**2 / 12.0 + off_middle**2)
    return np.asarray(wall * width**3 / 12.0 + of_sides)


def torsion_constant(
    height: ArrayLike, width: ArrayLike, wall: ArrayLike, side_wall: ArrayLike
) -> Array:
    """Bredt's torsion constant [m4] of the closed section, its passive layer as thick as the top
    wall; 0 without side walls.

    >>> round(float(torsion_constant(0.02, 0.02, 0.002, 0.002)) * 1e9, 2)
    12.64
    """
    height, width, wall, side_wall = _arrays(height, width, wall, side_wall)
    up, across = np.maximum(height - wall / 2.0, 0.0), width - side_wall
    # 4*A**2/(2*across/wall + 2*up/side_wall), written so that no side wall gives 0
    return np.asarray(
        2.0 * (up * across) ** 2 * wall * side_wall / (across * side_wall + up * wall)
    )


def lateral_stiffness(
    height: ArrayLike,
    width: ArrayLike,
    wall: ArrayLike,
    side_wall: ArrayLike,
    shear_modulus: ArrayLike,
) -> Array:
    """Stiffness 2*G*I [N m2] in lateral bending, with the modulus 2*G of the rule 3.25.

    >>> round(float(lateral_stiffness(0.02, 0.02, 0.002, 0.002, 67e3)) * 1e3, 3)
    0.963
    """
    second_moment = lateral_second_moment(height, width, wall, side_wall)
    return 2.0 * np.asarray(shear_modulus, float) * second_moment


def twist_stiffness(
    height: ArrayLike,
    width: ArrayLike,
    wall: ArrayLike,
    side_wall: ArrayLike,
    shear_modulus: ArrayLike,
) -> Array:
    """Stiffness G*J [N m2] in twist.

    >>> round(float(twist_stiffness(0.02, 0.02, 0.002, 0.002, 67e3)) * 1e3, 3)
    0.847
    """
    return np.asarray(shear_modulus, float) * torsion_constant(height, width, wall, side_wall)


def _arrays(*sizes: ArrayLike) -> list[Array]:
    return [np.asarray(size, float) for size in sizes]
