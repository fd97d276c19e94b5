"""Which springs the joints of a simulated chain have: those of the thesis, or better ones."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from softhand_model import side_stiffness
from softhand_model.actuator import Actuator
from softhand_model.document import Node

Array = NDArray[np.float64]

RULE, CURVATURE = "rule", "curvature"
SECTION = "section"
LEAST_STRETCH = 0.7  # below, rubber goes on in a straight line: what buckles there is left out


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

    >>> from softhand_model.actuator import load_actuator
    >>> springs = SpringModel(lateral="section", twist="section")
    >>> (springs.stiffness(load_actuator("P5"), 6)[0] * 1e3).round(2).tolist()
    [3.57, 21.17, 3.01]
    """

    bending: str = RULE
    lateral: float | str = 1.0
    twist: float | str = 1.0

    def stiffness(self, actuator: Actuator, segments: int) -> Array:
        """Joint stiffness (n, 3) [N m/rad] about x (height), y (bending) and z (length): that of
        the section in the middle of each segment over the segment's length, which the thesis does
        not say.
        """
        edge, x = actuator.length / segments, _middles(actuator, segments)
        bending, walls = actuator.stiffness(x), _walls(actuator, x)
        lateral, twist = (
            derived(*walls, modulus) if kind == SECTION else float(kind) * bending
            for kind, derived, modulus in (
                (self.lateral, side_stiffness.lateral_stiffness, self._modulus(actuator)),
                (self.twist, side_stiffness.twist_stiffness, actuator.shear_modulus),
            )
        )
        return np.stack([lateral, bending, twist], axis=1) / edge

    def side_by_side(self, actuator: Actuator, segments: int) -> Array:
        """Stiffness (n,) [N/m] of each segment's walls along the actuator, with which one of
        several in a chain resists lateral bending about the chain's middle; 0 unless `lateral` is
        of the section.
        """
        if self.lateral != SECTION:
            return np.zeros(segments)
        area = side_stiffness.wall_area(*_walls(actuator, _middles(actuator, segments)))
        return np.asarray(self._modulus(actuator) * area * segments / actuator.length)

    def _modulus(self, actuator: Actuator) -> float:
        """Modulus [Pa] of the walls along the actuator: as straight springs in bending have it."""
        return (2.0 if self.bending == RULE else 4.0) * actuator.shear_modulus

    def stretching(self, actuator: Actuator, segments: int) -> Array:
        """Stretch (n,) [1/rad] of the top with the bend of each segment's joint, h over the
        segment's length (eq. 3.13); 0 for linear springs.
        """
        if self.bending == RULE:
            return np.zeros(segments)
        edge = actuator.length / segments
        return np.asarray(actuator.height(_middles(actuator, segments)) / edge)


THESIS = SpringModel()


def _middles(actuator: Actuator, segments: int) -> Array:
    return (np.arange(segments) + 0.5) * actuator.length / segments


def _walls(actuator: Actuator, x: Array) -> tuple[Array, Array, float, float]:
    return actuator.height(x), actuator.width(x), actuator.wall, actuator.side_wall


def rubber_stress(stretch: Array) -> tuple[Array, Array]:
    """Elastic term q = u - u**-3 [-] (eq. 3.21) of the top at stretches u [-], and its slope [-].

    >>> [float(part) for part in rubber_stress(np.array(1.0))]
    [0.0, 4.0]
    """
    least = np.maximum(stretch, LEAST_STRETCH)
    slope = 1.0 + 3.0 * least**-4.0
    return least - least**-3.0 + slope * (stretch - least), slope


def read_springs(node: Node) -> SpringModel:
    """Springs of a model file: {bending, lateral, twist}, all optional."""
    fields = node.fields([], ["bending", "lateral", "twist"])
    bending = fields["bending"].choice([RULE, CURVATURE]) if "bending" in fields else RULE
    lateral, twist = (
        _sideways(fields[key]) if key in fields else 1.0 for key in ("lateral", "twist")
    )
    return SpringModel(bending, lateral, twist)


def _sideways(node: Node) -> float | str:
    if isinstance(node.value, str) and node.value != SECTION:
        raise node.error(f"a number above 0 or {SECTION}")
    return SECTION if node.value == SECTION else node.positive()
