"""Rubber and mesh that rub against themselves."""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar

import numpy as np

from softhand_model.effects.effect import RUBBER, Parameter
from softhand_model.effects.stages import Array, ElasticEffect, Memory, SectionShape, Strain


class Hysteresis(ElasticEffect):
    """Rate-independent: s_c*w added, dw = (sign(dlambda) - w)*abs(dlambda)/stretch_scale.

    The model of Duhem and Dahl, exact for any step in one direction: w goes to the sign of the
    motion over a stretch of stretch_scale. Section 5.2.4 sees 1 to 2 mm of it at the tip.
    """

    name = "hysteresis"
    experiments = RUBBER
    parameters = (
        Parameter(
            "relative_pressure",
            "",
            0.0,
            3.0,
            "half the height of the loop in units of the load s",
            typical=(0.02, 0.4),
            neutral=0.0,
        ),
        Parameter(
            "stretch_scale",
            "",
            1e-3,
            5.0,
            "stretch over which the friction turns",
            typical=(0.01, 0.3),
            logarithmic=True,
        ),
    )
    confounded_with: ClassVar[Mapping[str, str]] = {
        "viscoelasticity": "alike on triangles of one rate",
        "tube_lag": "alike on triangles of one rate",
        "mullins_softening": "both part loading from unloading",
    }
    has_memory = True
    adds = True
    rank = 1

    def stress(
        self, stress: Array, strain: Strain, shape: SectionShape, memory: Memory, dt: Array | float
    ) -> Array:
        """Stress [-] with the friction."""
        return stress + self.values["relative_pressure"] * self._turned(strain.stretch, memory)

    def remember(
        self, stress: Array, strain: Strain, shape: SectionShape, memory: Memory, dt: Array | float
    ) -> None:
        """Keep w and the stretch."""
        memory["state"] = self._turned(strain.stretch, memory), strain.stretch

    def _turned(self, stretch: Array, memory: Memory) -> Array:
        turned, before = memory.get("state", (0.0, 1.0))
        moved = stretch - before
        towards = np.sign(moved)
        left = np.exp(-np.abs(moved) / self.values["stretch_scale"])
        return towards + (turned - towards) * left
