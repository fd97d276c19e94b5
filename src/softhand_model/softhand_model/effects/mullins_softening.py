"""Rubber that is softer where it has been stretched before."""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar

import numpy as np

from softhand_model.effects.effect import RUBBER, Parameter
from softhand_model.effects.stages import Array, ElasticEffect, Memory, SectionShape, Strain


class MullinsSoftening(ElasticEffect):
    """Below the largest stretch so far: factor 1 - softening*(1 - exp(-(lam_max -
    lambda)/stretch_scale)).

    Named after L. Mullins; the thesis has elastic rubber only. The largest stretch belongs to the
    specimen, not to the run.
    """

    name = "mullins_softening"
    experiments = RUBBER
    parameters = (
        Parameter(
            "softening",
            "",
            0.0,
            0.95,
            "share of the stress that is lost far below the largest stretch",
            typical=(0.05, 0.5),
            neutral=0.0,
        ),
        Parameter(
            "stretch_scale",
            "",
            0.005,
            10.0,
            "distance from the largest stretch over which it is lost",
            typical=(0.05, 1.0),
            logarithmic=True,
        ),
    )
    confounded_with: ClassVar[Mapping[str, str]] = {
        "hysteresis": "both part loading from unloading: small loops after large ones tell",
    }
    has_memory = True
    largest: ClassVar[Mapping[str, float]] = {"largest_stretch": 1.0}

    def stress(
        self, stress: Array, strain: Strain, shape: SectionShape, memory: Memory, dt: Array | float
    ) -> Array:
        """Stress [-] times the factor."""
        below = np.maximum(memory.get("largest_stretch", 1.0) - strain.stretch, 0.0)
        lost = -np.expm1(-below / self.values["stretch_scale"])
        return stress * (1.0 - self.values["softening"] * lost)

    def remember(
        self, stress: Array, strain: Strain, shape: SectionShape, memory: Memory, dt: Array | float
    ) -> None:
        """Keep the largest stretch."""
        before = memory.get("largest_stretch", 1.0)
        memory["largest_stretch"] = np.maximum(strain.stretch, before)
