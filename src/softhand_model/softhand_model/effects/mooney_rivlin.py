"""Rubber whose energy depends on the second invariant too."""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar

from softhand_model.effects.effect import BENDING, Parameter
from softhand_model.effects.stages import Array, ElasticEffect, Memory, SectionShape, Strain


class MooneyRivlin(ElasticEffect):
    """Second term of Mooney and Rivlin: factor (1 + b/lambda)/(1 + b) in uniaxial tension, b =
    C01/C10; the shear modulus is that of both terms together (section 3.4.6).

    In bending the rubber is in pure shear, where J1 = J2 (eq. 3.18): the factor is 1.
    """

    name = "mooney_rivlin"
    experiments = frozenset({"uniaxial"})
    bases = frozenset({"pneuflex"})
    parameters = (
        Parameter(
            "c01_ratio",
            "",
            1e-4,
            50.0,
            "C01 over C10",
            typical=(0.05, 3.0),
            logarithmic=True,
        ),
    )
    unseen_in: ClassVar[Mapping[str, str]] = dict.fromkeys(
        sorted(BENDING), "changes nothing in bending, where J1 = J2"
    )
    confounded_with: ClassVar[Mapping[str, str]] = {
        "modulus_scale": "at large stretch it acts as a lower modulus",
    }

    def stress(
        self, stress: Array, strain: Strain, shape: SectionShape, memory: Memory, dt: Array | float
    ) -> Array:
        """Stress [-] times the factor."""
        if strain.mode != "uniaxial":
            return stress
        ratio = self.values["c01_ratio"]
        return stress * ((1.0 + ratio / strain.stretch) / (1.0 + ratio))
