"""Rubber that resists more when it is strained fast, and creeps afterwards."""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar

from softhand_model.effects.effect import RUBBER, Parameter
from softhand_model.effects.first_order import decay
from softhand_model.effects.stages import Array, ElasticEffect, Memory, SectionShape, Strain


class Viscoelasticity(ElasticEffect):
    """Standard linear solid: nu' = -nu/tau + g*Q', added to the elastic stress Q.

    The shear modulus is the relaxed one; at once the rubber is 1 + g times as stiff. Q is the
    stress after the stiffening factors. Exact for a stress that changes in a straight line over a
    step. (Zener's model; the thesis has elastic rubber only.)
    """

    name = "viscoelasticity"
    experiments = RUBBER
    parameters = (
        Parameter(
            "relative_modulus",
            "",
            0.0,
            5.0,
            "modulus of the part that relaxes, over the relaxed one",
            typical=(0.03, 0.6),
            neutral=0.0,
        ),
        Parameter(
            "relaxation_time",
            "s",
            1e-3,
            1e4,
            "time in which that part relaxes",
            typical=(0.1, 60.0),
            logarithmic=True,
        ),
    )
    confounded_with: ClassVar[Mapping[str, str]] = {
        "tube_lag": "alike on triangles of one rate",
        "hysteresis": "alike on triangles of one rate; steps and rates tell them apart",
    }
    has_memory = True
    adds = True
    _decay: tuple[Array | float, Array, Array] | None = None

    def stress(
        self, stress: Array, strain: Strain, shape: SectionShape, memory: Memory, dt: Array | float
    ) -> Array:
        """Stress [-] with the part that has not relaxed yet."""
        return stress + self._overstress(stress, memory, dt)

    def remember(
        self, stress: Array, strain: Strain, shape: SectionShape, memory: Memory, dt: Array | float
    ) -> None:
        """Keep the part that has not relaxed, and the stress."""
        memory["state"] = self._overstress(stress, memory, dt), stress

    def _overstress(self, stress: Array, memory: Memory, dt: Array | float) -> Array:
        over, before = memory.get("state", (0.0, 0.0))
        if self._decay is None or self._decay[0] is not dt:  # the same in all calls of a step
            self._decay = dt, *decay(dt, self.values["relaxation_time"])
        _, left, share = self._decay
        return left * over + self.values["relative_modulus"] * share * (stress - before)
