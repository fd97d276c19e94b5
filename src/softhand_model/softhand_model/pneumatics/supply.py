"""Air supply: compressor and tank, regulator, reservoir of the box."""

from __future__ import annotations

import numpy as np

from softhand_model.gas import GAS_CONSTANT, orifice_flow
from softhand_model.pneumatics.parameters import Pneumatics


class AirSupply:
    """Pressures of a compressor's tank and of the reservoir behind its regulator.

    The compressor runs from `cut_in` until `cut_out`. The regulator holds the reservoir at its set
    point, less a droop that grows with the flow and less the share `passed` of what the tank has
    lost; it was set with the tank full. Turned down, it vents the reservoir (self-relieving).
    Isothermal; pressures are absolute [Pa].

    >>> from softhand_model.pneumatics import load_pneumatics
    >>> AirSupply(load_pneumatics()).pressure
    401300.0
    """

    def __init__(self, parameters: Pneumatics) -> None:
        """Start with a full tank and the reservoir at the regulator's set point."""
        p, gas = parameters, GAS_CONSTANT * parameters.temperature
        self._ambient = p.ambient_pressure
        self._temperature = p.temperature
        self._nominal = p.supply.pressure
        self._droop = p.supply.droop
        self._capacity = p.supply.volume / gas  # [kg/Pa]
        self._tank_capacity = p.compressor.tank_volume / gas
        self._cut_in = p.compressor.cut_in + p.ambient_pressure
        self._cut_out = p.compressor.cut_out + p.ambient_pressure
        self._delivery = p.compressor.delivery
        self._passed = p.compressor.passed
        self.reset()

    def reset(self) -> None:
        """Fill the tank, and the reservoir to the nominal set point."""
        self.tank_pressure = self._cut_out
        self.compressor_runs = False
        self.set(self._nominal)
        self.pressure = self.setpoint

    def set(self, pressure: float) -> None:
        """Set the regulator to a gauge `pressure` [Pa]."""
        self.setpoint = pressure + self._ambient

    def step(self, dt: float, taken: float) -> None:
        """Simulate `dt` [s] in which the box has `taken` air [kg] from the reservoir."""
        self.pressure -= taken / self._capacity
        lost = self._passed * (self._cut_out - self.tank_pressure)
        target = min(self.setpoint - lost, self.tank_pressure)
        rate = dt / (dt + self._droop * self._capacity)
        change = rate * (target - self.pressure)
        self.pressure += change
        self._run_compressor(dt, max(change, 0.0) * self._capacity)

    def bleed(self, dt: float, taken: float, diameter: float) -> None:
        """The same with a closed regulator and a hole of `diameter` [m] in the reservoir."""
        self.pressure -= taken / self._capacity
        area = np.pi / 4 * diameter**2
        flow = float(orifice_flow(self.pressure, self._ambient, area, self._temperature))
        excess = self.pressure - self._ambient
        self.pressure -= min(flow * dt / self._capacity, max(excess, 0.0))
        self._run_compressor(dt, 0.0)

    def _run_compressor(self, dt: float, delivered: float) -> None:
        if self.tank_pressure <= self._cut_in:
            self.compressor_runs = True
        elif self.tank_pressure >= self._cut_out:
            self.compressor_runs = False
        gained = self._delivery * dt if self.compressor_runs else 0.0
        self.tank_pressure += (gained - delivered) / self._tank_capacity

    def save(self) -> tuple[float, float, float, bool]:
        """Return the changing state."""
        return self.pressure, self.setpoint, self.tank_pressure, self.compressor_runs

    def restore(self, saved: tuple[float, float, float, bool]) -> None:
        """Restore what `save` returned."""
        self.pressure, self.setpoint, self.tank_pressure, self.compressor_runs = saved
