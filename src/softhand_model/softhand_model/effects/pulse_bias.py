"""A mass that every pulse moves alike."""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar

from softhand_model.effects.effect import Parameter
from softhand_model.effects.stages import Array, FlowEffect, Pulse


class PulseBias(FlowEffect):
    """The bias c0 [kg] of a pulse, a value a direction: what the other terms get wrong on average
    (eq. 4.1).
    """

    name = "pulse_bias"
    experiments = frozenset({"valve_pulse"})
    parameters = (
        Parameter(
            "c0_inflate",
            "kg",
            -1e-4,
            1e-4,
            "mass added to every inflating pulse",
            typical=(1e-7, 2e-6),
            neutral=0.0,
        ),
        Parameter(
            "c0_deflate",
            "kg",
            -1e-4,
            1e-4,
            "mass added to every deflating pulse",
            typical=(1e-7, 2e-6),
            neutral=0.0,
        ),
    )
    confounded_with: ClassVar[Mapping[str, str]] = {
        "switching_volume": "alike while p_in varies little",
        "valve_delay": "a delay takes off c*p_in*delay, a bias while p_in varies little",
    }

    def act_on_mass(self, mass: Array, pulse: Pulse) -> Array:
        """Mass [kg] with the bias added."""
        return mass + self.by_direction("c0", pulse)
