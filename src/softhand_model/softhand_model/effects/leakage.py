"""A leak of the channel."""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar

import numpy as np

from softhand_model.effects.effect import Parameter
from softhand_model.effects.stages import Array, FlowEffect, Pulse
from softhand_model.gas import AMBIENT_PRESSURE


class Leakage(FlowEffect):
    """Air that leaks from the channel during a pulse: mass - conductance*(p_channel - p_ambient)
    *duration.

    p_channel is p_out inflating and p_in deflating, at switch-on; conductance in [kg/(s Pa)], that
    of a laminar gap; p_ambient is 101.3 kPa.
    """

    name = "leakage"
    experiments = frozenset({"valve_pulse"})
    parameters = (
        Parameter(
            "conductance",
            "kg/(s Pa)",
            0.0,
            1e-8,
            "mass flow of the leak per gauge pressure",
            typical=(1e-12, 5e-11),
            neutral=0.0,
        ),
    )
    confounded_with: ClassVar[Mapping[str, str]] = {
        "line_friction": "inflating, c1*(p_in - p_out) and a leak both fall linearly with p_out",
    }

    def act_on_mass(self, mass: Array, pulse: Pulse) -> Array:
        """Mass [kg] less what leaks."""
        channel = np.where(pulse.inflating, pulse.p_out, pulse.p_in)
        return mass - self.of("conductance") * (channel - AMBIENT_PRESSURE) * pulse.duration
