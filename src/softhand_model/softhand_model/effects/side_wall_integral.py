"""Side walls integrated over their height."""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar

from softhand_model import section
from softhand_model.effects.effect import BENDING
from softhand_model.effects.stages import Array, SectionShape, Strain, StructureEffect


class SideWallIntegral(StructureEffect):
    """The side walls' share without the approximation of 3.34: p*h/(2*G*d) = q + term.

    The base puts one factor 2/ratio on q (eq. 3.35); here the elastic side is (ratio/2)*(q + term)
    with `section.side_wall_term`. It acts nearly as a factor of 0.78 on the modulus.
    """

    name = "side_wall_integral"
    experiments = BENDING
    unseen_in: ClassVar[Mapping[str, str]] = {
        "uniaxial": "a strip in tension has no side walls",
    }
    confounded_with: ClassVar[Mapping[str, str]] = {
        "modulus_scale": "nearly a factor of 0.78 on it",
        "pressure_gain": "nearly a factor of 1.28 on the pressure",
    }

    def wall_stress(self, stress: Array, strain: Strain, shape: SectionShape) -> Array:
        """Elastic side [-] with the integral in place of the factor."""
        curvature = (strain.stretch - 1.0) / shape.height
        term = section.side_wall_term(
            curvature, shape.height, shape.width, shape.wall, shape.side_wall
        )
        return 0.5 * shape.ratio * (stress + term)
