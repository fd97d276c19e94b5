"""Viscous friction along the flow path."""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar

from softhand_model.effects.effect import Parameter
from softhand_model.effects.stages import Array, FlowEffect, Pulse


class LineFriction(FlowEffect):
    """Flow against the viscous friction of the walls: c1*int(p_in - p_out) dt (eq. 4.1).

    c1 [kg/(s Pa)] has a value a direction. The thesis adds it to the flow through the choke though
    the two resistances lie in series, so beside `injector_flow` a c1 below zero makes sense: the
    tube takes away what the choke alone would pass.
    """

    name = "line_friction"
    experiments = frozenset({"valve_pulse"})
    parameters = (
        Parameter(
            "c1_inflate",
            "kg/(s Pa)",
            -1e-8,
            1e-8,
            "conductance of the line to the channel",
            typical=(1e-12, 5e-11),
            neutral=0.0,
        ),
        Parameter(
            "c1_deflate",
            "kg/(s Pa)",
            -1e-8,
            1e-8,
            "conductance of the line from the channel",
            typical=(1e-11, 5e-10),
            neutral=0.0,
        ),
    )
    confounded_with: ClassVar[Mapping[str, str]] = {
        "injector_flow": "both fall as the pressures even out",
        "leakage": "inflating, c1*(p_in - p_out) and a leak both fall linearly with p_out",
    }

    def act_on_mass(self, mass: Array, pulse: Pulse) -> Array:
        """Mass [kg] with the friction term added."""
        return mass + self.by_direction("c1", pulse) * pulse.friction_integral
