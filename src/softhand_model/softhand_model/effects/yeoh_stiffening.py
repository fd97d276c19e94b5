"""Rubber that stiffens with its strain."""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar

from softhand_model.effects.effect import RUBBER, Parameter
from softhand_model.effects.stages import Array, ElasticEffect, Memory, SectionShape, Strain


class YeohStiffening(ElasticEffect):
    """Second term of Yeoh's energy: factor 1 + 2*c2*J1, c2 = C20/C10 (section 3.4.6).

    Silicones have about C20 = C10/500 there.
    """

    name = "yeoh_stiffening"
    experiments = RUBBER
    parameters = (
        Parameter(
            "c2",
            "",
            1e-5,
            5.0,
            "second coefficient of the energy over the first",
            typical=(0.005, 0.2),
            logarithmic=True,
        ),
    )
    confounded_with: ClassVar[Mapping[str, str]] = {
        "gent_stiffening": "the same to first order, jm = 1/(2*c2): only large strain tells",
    }

    def stress(
        self, stress: Array, strain: Strain, shape: SectionShape, memory: Memory, dt: Array | float
    ) -> Array:
        """Stress [-] times the factor."""
        return stress * (1.0 + 2.0 * self.values["c2"] * strain.invariant)
