"""A supply that gives way to the flow that is taken from it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar

import numpy as np

from softhand_model.effects.effect import Parameter
from softhand_model.effects.stages import Array, FlowEffect, Pulse


class SupplyDroop(FlowEffect):
    """Inflating, the supply falls with the mean flow: p_in -> p_in - resistance*mass/duration.

    resistance [Pa s/kg]. The mass is the pulse's own, so the equation is implicit; the integrals
    are measured, with what the supply did, and stay.
    """

    name = "supply_droop"
    experiments = frozenset({"valve_pulse"})
    parameters = (
        Parameter(
            "resistance",
            "Pa s/kg",
            0.0,
            1e11,
            "loss of supply pressure per mass flow",
            typical=(1e8, 1e10),
            neutral=0.0,
        ),
    )
    confounded_with: ClassVar[Mapping[str, str]] = {
        "calibration": "with the naive term c*p_in*duration alone a factor 1/(1 + resistance*c) "
        "on c while inflating; it shows beside switching_volume only",
    }

    def act_on_pulse(self, pulse: Pulse, mass: Array) -> Pulse:
        """The pulse with the supply pressure that is left to it."""
        lasting = np.where(pulse.duration > 0.0, pulse.duration, np.inf)
        loss = np.where(pulse.inflating, self.of("resistance") * mass / lasting, 0.0)
        return pulse.fed_at(pulse.p_in - loss)
