"""Rubber whose chains can be stretched so far and no further."""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar

import numpy as np

from softhand_model.effects.effect import RUBBER, Parameter
from softhand_model.effects.stages import Array, ElasticEffect, Memory, SectionShape, Strain

ALMOST = 0.99  # of jm, from where the factor goes on in a straight line and so stays finite


class GentStiffening(ElasticEffect):
    """Gent's limit of extension: factor 1/(1 - J1/jm) (eq. 3.45).

    jm [-] is the invariant J1 at which the rubber locks. ERRATUM: 3.45 prints the energy without
    its minus sign; W = -(G/2)*Jm*log(1 - J1/Jm) gives this factor.
    """

    name = "gent_stiffening"
    experiments = RUBBER
    parameters = (
        Parameter(
            "jm",
            "",
            0.5,
            1000.0,
            "invariant J1 at which the rubber locks",
            typical=(2.0, 60.0),
            logarithmic=True,
        ),
    )
    confounded_with: ClassVar[Mapping[str, str]] = {
        "yeoh_stiffening": "the same to first order, c2 = 1/(2*jm): only large strain tells",
    }

    def stress(
        self, stress: Array, strain: Strain, shape: SectionShape, memory: Memory, dt: Array | float
    ) -> Array:
        """Stress [-] times the factor."""
        share = strain.invariant / self.values["jm"]
        below = 1.0 / (1.0 - np.minimum(share, ALMOST))
        return stress * (below + np.maximum(share - ALMOST, 0.0) / (1.0 - ALMOST) ** 2)
