"""The pneumatic plant with its flow step compiled: the same physics, twenty times faster.

Without numba the numpy step of `softhand_model.pneumatics.plant` is the faster one and stays.
"""

from __future__ import annotations

import math

import numpy as np

from pneuflex_sim.compiled import COMPILED, compiled
from softhand_model.gas import CRITICAL_RATIO, HEAT_CAPACITY_RATIO
from softhand_model.pneumatics.plant import PneumaticPlant

IN, OUT = 0, 1
ROOT = 1 / HEAT_CAPACITY_RATIO
EXPONENT = HEAT_CAPACITY_RATIO / (HEAT_CAPACITY_RATIO - 1)
TINY = float(np.finfo(float).tiny)


class CompiledPlant(PneumaticPlant):
    """`PneumaticPlant` whose substep runs in a compiled loop over channels."""

    def _substep(self, dt: float) -> None:
        state = self._valves.advance(self.time + dt / 2)
        at_box = np.empty(len(state) + 1)
        ambient = self.parameters.ambient_pressure
        taken = move_air(
            dt,
            state,
            (self.supply_pressure, ambient),
            self._volumes / self._gas,
            self._dead_capacity,
            (self._choke, self._choke_and_valve, self._line),
            (self._air, self._dead, self.inflow, self.outflow, self._net_flow),
            at_box,
        )
        self._supply_step(dt, taken)
        at_box[-1] = self.supply_pressure
        self._sensors.follow(dt, at_box)
        self.time += dt


@compiled
def move_air(dt, state, outer, capacity, dead_capacity, resistance, contents, at_box):
    """One step of all channels in place; returns what left the supply [kg].

    `state` (n,) spools; `outer` (supply, ambient) [Pa]; `capacity` (n,), `dead_capacity` [kg/Pa];
    `resistance` (chokes (2, n), chokes with valves (2, n), lines (n,)); `contents` (air (n,), dead
    volumes (2, n), inflow, outflow (n,) [kg], net flow (n,) [kg/s]); `at_box` (n + 1,) [Pa] becomes
    the pressure that the sensors see. Flow as in `softhand_model.gas.series_flow`.
    """
    choke, choke_and_valve, line = resistance
    air, dead, inflow, outflow, net_flow = contents
    taken = 0.0
    for i in range(len(state)):
        pressure, net = air[i] / capacity[i], 0.0
        for path in range(2):
            opened = state[i] > 0 if path == IN else state[i] < 0
            through = 0.0
            if opened:
                through = outer[path] * dead_capacity - dead[path, i]
                dead[path, i] += through
            inner = dead[path, i] / dead_capacity
            high, low = max(inner, pressure), min(inner, pressure)
            ratio = min(max(low / high, CRITICAL_RATIO), 1.0)
            root = ratio**ROOT
            psi = math.sqrt(EXPONENT * root * (root - ratio))
            orifice = choke_and_valve[path, i] if opened else choke[path, i]
            by_orifice = orifice * high * psi
            by_line = line[i] * (high * high - low * low)
            total = by_orifice + math.sqrt(by_orifice * by_orifice + 4.0 * by_line * by_line)
            flow = 2.0 * by_orifice * by_line / max(total, TINY)
            both = capacity[i] * dead_capacity / (capacity[i] + dead_capacity)
            most = (high - low) * (capacity[i] if opened else both)
            moved = math.copysign(min(flow * dt, most), inner - pressure)
            net += moved
            if opened:
                through += moved
            else:
                dead[path, i] -= moved
            if path == IN:
                inflow[i] += through
                taken += through
            else:
                outflow[i] -= through
        air[i] += net
        net_flow[i] = net / dt
        after = air[i] / capacity[i]
        at_box[i] = math.sqrt(max(after * after + net_flow[i] / line[i], 0.0))
    return taken


PLANT = CompiledPlant if COMPILED else PneumaticPlant
