"""Walls that are too thick to count as a membrane."""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from softhand_model.effects.effect import BENDING, Parameter
from softhand_model.effects.stages import Array, ElasticEffect, Memory, SectionShape, Strain

STRETCH_SCALE = 0.25  # over which the excess fades
LARGEST_EXCESS = 3.0  # gain*(2d/h)**2, from where the elastic side would fall


class ThickWall(ElasticEffect):
    """Empirical: factor 1 + gain*min(2*d/h, 1)**2*exp(-(lambda - 1)/0.25).

    A thick wall is stiffer at small bending than the membrane of eq. 3.21: another guess at the
    riddle of section 5.2.2 (`section_rounding`). gain*(2*d/h)**2 must not exceed 3.
    """

    name = "thick_wall"
    experiments = BENDING
    bases = frozenset({"pneuflex"})
    parameters = (
        Parameter(
            "gain",
            "",
            0.0,
            300.0,
            "excess of the stiffness at no strain and d = h/2",
            typical=(0.3, 8.0),
            neutral=0.0,
        ),
    )
    unseen_in: ClassVar[Mapping[str, str]] = {
        "uniaxial": "a strip in tension has no wall to bend",
    }
    confounded_with: ClassVar[Mapping[str, str]] = {
        "section_rounding": "alike on one wall thickness: specimens of several tell them apart",
        "actuation_nonlinearity": "alike on one wall thickness",
    }

    def stress(
        self, stress: Array, strain: Strain, shape: SectionShape, memory: Memory, dt: Array | float
    ) -> Array:
        """Stress [-] times the factor."""
        return stress * (1.0 + self._excess(shape) * np.exp((1.0 - strain.stretch) / STRETCH_SCALE))

    def allows(self, shape: SectionShape) -> NDArray[np.bool_] | bool:
        """Whether the excess is within its limit."""
        return self._excess(shape) <= LARGEST_EXCESS

    def _excess(self, shape: SectionShape) -> Array:
        return self.values["gain"] * np.minimum(2.0 * shape.wall / shape.height, 1.0) ** 2
