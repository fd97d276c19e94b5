"""Stiffness of a chain's joints in bending (by the rule of the thesis or dependent on the
curvature), sideways and in twist.

The section is that of chapter 3: height h, width z, a top wall of thickness d, two side walls, and
below them the passive layer, a mesh in rubber.

All three axes take one deformation: a fibre at height y and off the middle by r, with curvatures
kappa and lateral k, is stretched by lambda = 1 + kappa*y + k*r. The thread runs around every wall,
so none strains around (3.18), top and sides alike, and the energy is G/2*(lambda**2 + lambda**-2 -
2). Its second derivative is the tangent modulus G*(1 + 3*lambda**-4) of 3.24 about either axis: 4*G
at rest, as in plane strain, 2*G at lambda = 1.316, G far out. (3*G would be rubber pulled one way
that is free to shrink: no wall, unless the thread is slack where pressure does not hold it taut.)

Lateral bending (about the height): B = modulus*I, I the second moment of the walls about the plane
in their middle. Modulus 2*G is that of the rule 3.25, 4*G that of a straight actuator by 3.24; what
the springs take is said in `SpringModel`. Bent, the walls' tangent falls: a P10's base from 4*G*I
to 2.6*G*I at 90 deg (top at lambda = 1.35) and to 2*G*I where the top is at 1.76, later than 1.316
because side walls are stretched less. Up to there 2*G*I is what the rubber alone has at least, not
beyond. The passive layer counts for nothing: a mesh bears no compression.

Actuators side by side whose sections stay in one plane are stretched and compressed as well:
modulus*A*offset**2 each (Steiner), A the area of the walls.

Twist shears the walls. Neo-Hookean rubber has the nominal shear stress G*gamma whatever its
stretch, and one shear flow runs around the closed section: B_twist = G*J with Bredt's J =
4*A**2/integral(ds/t) along the middle of the walls. The passive layer counts as rubber as thick as
the top wall; its mesh shears freely.

Left out. Mesh, sideways: while it is taut it adds E*t*z**3/12, E*t its stiffness per width. The
pressure pulls it by at most N = h*z*p/2, so it slackens on one side from a moment of N*z/6 on.
Where it does not stretch at all, nothing gives way before N*z/2, all of N in one edge; then the
actuator turns about that edge, where I is 2.3 times as large (thin walls, h = z). Mesh, in twist: a
passive layer that does not shear makes J at most 4/3 as large (h = z, all walls alike), a layer
that shears without resistance leaves an open section with next to none. Pressure: a section that
turns about the middle of the passive layer keeps its area, so it does no work; the mesh's tension
adds h*z**3*p/24, the tension of the rubber at most half of J. Thread: a single helix couples twist
to pressure and to lateral bending (`bend_twist_coupling`), thread wound both ways stiffens against
twist.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from softhand_common.documents.yaml_document import Node
from softhand_common.numerics.arrays import Array
from softhand_common.numerics.compiled import compiled
from softhand_model.hand.actuator import Actuator
from softhand_model.hand.section import arrays

BY_RULE, BY_CURVATURE = "rule", "curvature"
BY_SECTION = "section"
DAMPING_TIME = 0.01  # Kelvin-Voigt: damping of a joint over its stiffness [s]
LEAST_STRETCH = 0.7  # below, the rubber is extrapolated linearly, without buckling


def lateral_second_moment(
    height: ArrayLike, width: ArrayLike, wall: ArrayLike, side_wall: ArrayLike
) -> Array:
    """Second moment [m4] of top and side walls about the plane in the middle of the width. Sizes
    are in [m].

    >>> round(float(lateral_second_moment(0.02, 0.02, 0.002, 0.002)) * 1e9, 3)
    7.189
    """
    height, width, wall, side_wall = arrays(height, width, wall, side_wall)
    inner = np.maximum(height - wall, 0.0)
    off_middle = (width - side_wall) / 2.0
    of_sides = 2.0 * inner * side_wall * (side_wall**2 / 12.0 + off_middle**2)
    return np.asarray(wall * width**3 / 12.0 + of_sides)


def torsion_constant(
    height: ArrayLike, width: ArrayLike, wall: ArrayLike, side_wall: ArrayLike
) -> Array:
    """Bredt's torsion constant [m4] of the closed section, whose passive layer counts as thick as
    the top wall; 0 without side walls. Sizes are in [m].

    >>> round(float(torsion_constant(0.02, 0.02, 0.002, 0.002)) * 1e9, 2)
    12.64
    """
    height, width, wall, side_wall = arrays(height, width, wall, side_wall)
    up, across = np.maximum(height - wall / 2.0, 0.0), width - side_wall
    # 4*A**2/(2*across/wall + 2*up/side_wall), written so that no side wall gives 0
    return np.asarray(
        2.0 * (up * across) ** 2 * wall * side_wall / (across * side_wall + up * wall)
    )


def wall_area(height: ArrayLike, width: ArrayLike, wall: ArrayLike, side_wall: ArrayLike) -> Array:
    """Area [m2] of top and side walls. Sizes are in [m].

    >>> round(float(wall_area(0.009, 0.009, 0.003, 0.003)) * 1e6, 6)
    63.0
    """
    height, width, wall, side_wall = arrays(height, width, wall, side_wall)
    return np.asarray(wall * width + 2.0 * np.maximum(height - wall, 0.0) * side_wall)


def lateral_stiffness(
    height: ArrayLike, width: ArrayLike, wall: ArrayLike, side_wall: ArrayLike, modulus: ArrayLike
) -> Array:
    """Stiffness modulus*I [N m2] in lateral bending. modulus [Pa]: tangent modulus of the walls
    along the actuator, which is 2*G by the rule 3.25.

    >>> round(float(lateral_stiffness(0.02, 0.02, 0.002, 0.002, 2 * 67e3)) * 1e3, 3)
    0.963
    """
    return np.asarray(modulus, float) * lateral_second_moment(height, width, wall, side_wall)


def twist_stiffness(
    height: ArrayLike,
    width: ArrayLike,
    wall: ArrayLike,
    side_wall: ArrayLike,
    shear_modulus: ArrayLike,
) -> Array:
    """Stiffness G*J [N m2] in twist. Sizes are in [m], shear_modulus in [Pa].

    >>> round(float(twist_stiffness(0.02, 0.02, 0.002, 0.002, 67e3)) * 1e3, 3)
    0.847
    """
    return np.asarray(shear_modulus, float) * torsion_constant(height, width, wall, side_wall)


@dataclass(frozen=True)
class SpringModel:
    """Springs of the joints, by default those of the thesis.

    bending: `rule`, the linear springs of `Actuator.stiffness`, eq. 3.26 times 2/ratio for the side
        walls (eq. 3.35, ERRATUM there), or `curvature`, whose tangent stiffness is that of eq. 3.24
        times the same: with u the stretch of the top, the moment is that of u - u**-3.
    lateral, twist: stiffness about height and length over that in bending by the rule [-], 1 "for
        want of a model" (5.2.4); or `section`, what `side_stiffness` derives from the section.
        Lateral springs are linear; their modulus is that of the springs in bending when straight,
        2*G with `rule` and 4*G with `curvature`.

    >>> from softhand_model.hand.actuator import load_actuator
    >>> springs = SpringModel(lateral="section", twist="section")
    >>> (springs.stiffness(load_actuator("P5"), 6)[0] * 1e3).round(2).tolist()
    [3.57, 21.17, 3.01]
    """

    bending: str = BY_RULE
    lateral: float | str = 1.0
    twist: float | str = 1.0

    def stiffness(self, actuator: Actuator, segments: int) -> Array:
        """Joint stiffness (n, 3) [N m/rad] about x (height), y (bending) and z (length): that of
        the section in the middle of each segment, over the length of the segment. (The thesis does
        not state where it evaluates the section.)
        """
        edge, x = actuator.length / segments, _middles(actuator, segments)
        bending, walls = actuator.stiffness(x), actuator.sides(x)
        lateral, twist = (
            derived(*walls, modulus) if kind == BY_SECTION else float(kind) * bending
            for kind, derived, modulus in (
                (self.lateral, lateral_stiffness, self._modulus(actuator)),
                (self.twist, twist_stiffness, actuator.shear_modulus),
            )
        )
        return np.stack([lateral, bending, twist], axis=1) / edge

    def side_by_side(self, actuator: Actuator, segments: int) -> Array:
        """Stiffness (n,) [N/m] of the walls of each segment against stretching along the actuator.
        With it, one of several actuators in a chain resists lateral bending about the middle of the
        chain. 0 unless `lateral` is `section`.
        """
        if self.lateral != BY_SECTION:
            return np.zeros(segments)
        area = wall_area(*actuator.sides(_middles(actuator, segments)))
        return np.asarray(self._modulus(actuator) * area * segments / actuator.length)

    def _modulus(self, actuator: Actuator) -> float:
        """Modulus [Pa] of the walls along the actuator: as straight springs in bending have it."""
        return (2.0 if self.bending == BY_RULE else 4.0) * actuator.shear_modulus

    def stretching(self, actuator: Actuator, segments: int) -> Array:
        """Stretch (n,) [1/rad] of the top per bend of the joint of each segment: h over the length
        of the segment (eq. 3.13). 0 for linear springs.
        """
        if self.bending == BY_RULE:
            return np.zeros(segments)
        edge = actuator.length / segments
        return np.asarray(actuator.height(_middles(actuator, segments)) / edge)


THESIS = SpringModel()


def _middles(actuator: Actuator, segments: int) -> Array:
    return (np.arange(segments) + 0.5) * actuator.length / segments


def rubber_stress(stretch: Array) -> tuple[Array, Array]:
    """Elastic term q = u - u**-3 [-] (eq. 3.21) of the top at stretches u [-], and its slope [-].

    >>> [float(part) for part in rubber_stress(np.array(1.0))]
    [0.0, 4.0]
    """
    stress, slope = rubber_terms.py_func(stretch)
    return stress, slope


@compiled
def rubber_terms(stretch: Any) -> Any:
    """(elastic term, slope) [-] as `rubber_stress`, for numbers or arrays."""
    least = np.maximum(stretch, LEAST_STRETCH)
    inverse = 1.0 / least
    cube = inverse * inverse * inverse
    slope = 1.0 + 3.0 * cube * inverse
    return least - cube + slope * (stretch - least), slope


def read_springs(node: Node) -> SpringModel:
    """Read the springs of a model file: {bending, lateral, twist}, all optional; raises
    DocumentError for values that are not valid.
    """
    fields = node.fields([], ["bending", "lateral", "twist"])
    bending = fields["bending"].choice([BY_RULE, BY_CURVATURE]) if "bending" in fields else BY_RULE
    lateral, twist = (
        _sideways(fields[key]) if key in fields else 1.0 for key in ("lateral", "twist")
    )
    return SpringModel(bending, lateral, twist)


def _sideways(node: Node) -> float | str:
    if isinstance(node.value, str) and node.value != BY_SECTION:
        raise node.error(f"a number above 0 or {BY_SECTION}")
    return BY_SECTION if node.value == BY_SECTION else node.number(above=0.0, high=1e3)
