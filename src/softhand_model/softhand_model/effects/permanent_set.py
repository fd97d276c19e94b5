"""Permanent set: rubber that was stretched does not return to its length."""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar

import numpy as np

from softhand_common.numerics.arrays import Array
from softhand_common.numerics.compiled import compiled
from softhand_model.effects.effect import RUBBER, Parameter
from softhand_model.effects.kernel import UNIAXIAL, Kernel, Trial, base_stress
from softhand_model.effects.stages import ElasticEffect, Memory, SectionShape, Strain

LARGEST = 0  # row of its state


@compiled
def _set(stress: Array, trial: Trial, values: Array, state: Array) -> None:
    for lane in range(len(stress)):
        stretch = trial.stretch[lane]
        largest = max(state[LARGEST, lane], stretch)
        further = stretch / (1.0 + values[0, lane] * (largest - 1.0))
        if trial.mode == UNIAXIAL:
            further = max(further, 1.0)
        stress[lane] += base_stress(further, trial.mode) - base_stress(stretch, trial.mode)
        if trial.accepted:
            state[LARGEST, lane] = largest


class PermanentSet(ElasticEffect):
    """Permanent set: at rest the rubber keeps `share` of its largest strain so far. The elastic
    stress q(lambda) becomes q(lambda/lam_rest), lam_rest = 1 + share*(lam_max - 1). A strip in
    tension that is shorter than at rest hangs slack.

    The largest stretch belongs to the specimen, not to the run.
    """

    name = "permanent_set"
    experiments = RUBBER
    parameters = (
        Parameter(
            "share",
            "",
            0.0,
            0.6,
            "strain that stays at rest, over the largest strain so far",
            (0.01, 0.2),
            neutral=0.0,
        ),
    )
    confounded_with: ClassVar[Mapping[str, str]] = {
        "mullins_softening": "both depend on the largest stretch: only a set shows at rest",
        "sensor_drift": "alike where the largest stretch grows from run to run",
    }
    has_memory = True
    adds = True
    largest: ClassVar[Mapping[str, float]] = {"largest_stretch": 1.0}
    kernel = Kernel(_set)

    def stress(
        self, stress: Array, strain: Strain, shape: SectionShape, memory: Memory, dt: Array | float
    ) -> Array:
        """Stress [-] (divided by the shear modulus) of rubber that is longer at rest."""
        largest = np.maximum(memory.get("largest_stretch", 1.0), strain.stretch)
        further = strain.stretch / (1.0 + self.values["share"] * (largest - 1.0))
        if strain.mode == "uniaxial":
            further = np.maximum(further, 1.0)
        return stress + Strain(further, strain.mode).elastic_term - strain.elastic_term

    def remember(
        self, stress: Array, strain: Strain, shape: SectionShape, memory: Memory, dt: Array | float
    ) -> None:
        """Store the largest stretch."""
        before = memory.get("largest_stretch", 1.0)
        memory["largest_stretch"] = np.maximum(strain.stretch, before)
