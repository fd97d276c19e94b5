"""Temperature of the air in the channels: a lumped energy balance of each."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from softhand_model.gas import GAS_CONSTANT, HEAT_CAPACITY_RATIO

Floats = NDArray[np.float64]
HEAT_CAPACITY = GAS_CONSTANT / (HEAT_CAPACITY_RATIO - 1)  # of air at constant volume [J/(kg K)]


class ChannelHeat:
    """Temperature (n,) [K] of ideal, well-mixed air in `n` channels.

    First law for the air of a channel: `d(m c_v T) = c_p T_wall dm_in - c_p T dm_out - p dV -
    m c_v (T - T_wall)/tau dt`; air comes in at the temperature of the walls. Each term is taken in
    its exact solution, one after the other. `heat` counts what the walls have taken [J].

    Args:
        channels: number of channels.
        wall: temperature of walls, supply and surroundings [K].
        time_constant: `tau`, in which the air takes on the wall's temperature [s].
    """

    def __init__(self, channels: int, wall: float, time_constant: float) -> None:
        self._wall, self._time_constant = wall, time_constant
        self.temperature: Floats = np.full(channels, wall)
        self.heat: Floats = np.zeros(channels)

    def compress(self, ratio: Floats) -> None:
        """Change the volumes by `ratio` (n,) = new/old without heat: `T V**(kappa - 1)` stays."""
        self.temperature = self.temperature * ratio ** (1 - HEAT_CAPACITY_RATIO)

    def exchange(self, dt: float, air: Floats) -> None:
        """Let the walls take heat from the `air` (n,) [kg] for `dt` [s]."""
        excess = self.temperature - self._wall
        change = excess * -np.expm1(-dt / self._time_constant)
        self.temperature = self.temperature - change
        self.heat += HEAT_CAPACITY * air * change

    def mix(self, air: Floats, received: Floats, net: Floats) -> None:
        """Let air in, then out.

        Args:
            air: in the channels, before (n,) [kg].
            received: air that came in (n,) [kg].
            net: air that came in less air that left (n,) [kg].
        """
        if received.any():
            energy = air * self.temperature + HEAT_CAPACITY_RATIO * received * self._wall
            self.temperature = energy / (air + received)
        left = (air + net) / (air + received)  # what stays expands without heat
        self.temperature = self.temperature * left ** (HEAT_CAPACITY_RATIO - 1)

    def save(self) -> dict[str, Any]:
        """Return a copy of the changing state."""
        return {"temperature": self.temperature.copy(), "heat": self.heat.copy()}

    def restore(self, saved: dict[str, Any]) -> None:
        """Go back to what `save` returned."""
        self.temperature, self.heat = saved["temperature"].copy(), saved["heat"].copy()
