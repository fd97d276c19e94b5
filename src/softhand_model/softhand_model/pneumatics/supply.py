"""Air supply: compressor and tank, regulator, reservoir of the box."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from softhand_common.numerics.arrays import Array
from softhand_common.numerics.compiled import compiled
from softhand_model.gas import GAS_CONSTANT, orifice_flow
from softhand_model.pneumatics.parameters import Pneumatics

RESERVOIR, SETPOINT, TANK, COMPRESSING = range(
    4
)  # of the state: absolute [Pa], the last one 0 or 1


class Supply(NamedTuple):
    """Constants of a supply.

    capacity [kg/Pa]: of the reservoir. sluggishness [s]: droop of the regulator times that
    capacity. tank_capacity [kg/Pa]. cut_in, cut_out [Pa]: absolute pressures at which the
    compressor starts and stops. delivery [kg/s]: of the compressor. passed [-]: share of the tank's
    loss of pressure that the regulator passes on.
    """

    capacity: float
    sluggishness: float
    tank_capacity: float
    cut_in: float
    cut_out: float
    delivery: float
    passed: float


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
        self._ambient, self._temperature = p.ambient_pressure, p.temperature
        self._nominal = p.supply.pressure
        capacity = p.supply.volume / gas  # [kg/Pa]
        self.constants = Supply(
            capacity,
            p.supply.droop * capacity,
            p.compressor.tank_volume / gas,
            p.compressor.cut_in + p.ambient_pressure,
            p.compressor.cut_out + p.ambient_pressure,
            p.compressor.delivery,
            p.compressor.passed,
        )
        self.state: Array = np.zeros(4)
        self.reset()

    def reset(self) -> None:
        """Fill the tank, and the reservoir to the nominal set point."""
        self.set(self._nominal)
        self.state[:] = self.state[SETPOINT], self.state[SETPOINT], self.constants.cut_out, 0.0

    def set(self, pressure: float) -> None:
        """Set the regulator to a gauge `pressure` [Pa]."""
        self.state[SETPOINT] = pressure + self._ambient

    @property
    def pressure(self) -> float:
        """Absolute pressure in the reservoir [Pa]."""
        return float(self.state[RESERVOIR])

    @property
    def tank_pressure(self) -> float:
        """Absolute pressure in the compressor's tank [Pa]."""
        return float(self.state[TANK])

    @property
    def compressor_runs(self) -> bool:
        """Whether the compressor delivers air into the tank."""
        return bool(self.state[COMPRESSING])

    def step(self, dt: float, taken: float) -> None:
        """Simulate `dt` [s] in which the box has `taken` air [kg] from the reservoir."""
        supply_air(dt, taken, self.state, tuple(self.constants))

    def bleed(self, dt: float, taken: float, diameter: float) -> None:
        """Simulate `dt` [s] in which the box has `taken` air [kg], with a closed regulator and a
        hole of `diameter` [m] in the reservoir.
        """
        capacity, pressure = self.constants.capacity, self.pressure
        pressure -= taken / capacity
        area = np.pi / 4 * diameter**2
        flow = float(orifice_flow(pressure, self._ambient, area, self._temperature))
        excess = pressure - self._ambient
        self.state[RESERVOIR] = pressure - min(flow * dt / capacity, max(excess, 0.0))
        run_compressor(dt, 0.0, self.state, tuple(self.constants))

    def save(self) -> Array:
        """Return the changing state."""
        return self.state.copy()

    def restore(self, saved: Array) -> None:
        """Restore what `save` returned."""
        self.state[:] = saved


@compiled
def supply_air(dt: float, taken: float, state: Array, constants: Any) -> None:
    """`AirSupply.step` on its `state` (4,), which is changed in place; `constants` are the fields
    of `Supply`.
    """
    capacity, sluggish, _, _, cut_out, _, passed = constants
    state[RESERVOIR] -= taken / capacity
    lost = passed * (cut_out - state[TANK])
    target = min(state[SETPOINT] - lost, state[TANK])
    change = dt / (dt + sluggish) * (target - state[RESERVOIR])
    state[RESERVOIR] += change
    run_compressor(dt, max(change, 0.0) * capacity, state, constants)


@compiled
def run_compressor(dt: float, delivered: float, state: Array, constants: Any) -> None:
    """Take `delivered` air [kg] from the tank and let the compressor run for `dt` [s], if it does;
    arguments as of `supply_air`.
    """
    _, _, tank_capacity, cut_in, cut_out, delivery, _ = constants
    if state[TANK] <= cut_in:
        state[COMPRESSING] = 1.0
    elif state[TANK] >= cut_out:
        state[COMPRESSING] = 0.0
    gained = delivery * dt if state[COMPRESSING] else 0.0
    state[TANK] += (gained - delivered) / tank_capacity
