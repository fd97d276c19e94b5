"""Air that has not come back to room temperature when its pressure is read."""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar

from softhand_model.effects.effect import Parameter
from softhand_model.effects.stages import Array, FlowEffect, Pulse


class PolytropicGas(FlowEffect):
    """A measured mass dp*V/(R_s*T) of air that changes by p*V**n = const is n times the true one.

    exponent n: 1 isothermal (the base), 1.4 adiabatic. It is a mere factor on the mass.
    """

    name = "polytropic_gas"
    experiments = frozenset({"valve_pulse"})
    parameters = (
        Parameter("exponent", "", 1.0, 1.4, "of the change of state", (1.02, 1.35), neutral=1.0),
    )
    unseen_in: ClassVar[Mapping[str, str]] = {
        "valve_pulse": "a mere factor on the mass, which the calibration of both directions takes "
        "up",
    }
    confounded_with: ClassVar[Mapping[str, str]] = {"calibration": "a factor on both directions"}
    rank = 1

    def act_on_mass(self, mass: Array, pulse: Pulse) -> Array:
        """Mass [kg] as read by who takes the air to be isothermal."""
        return mass * self.of("exponent")
