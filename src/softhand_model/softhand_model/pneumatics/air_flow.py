"""Air between valves, dead volumes and channels: one step of its flow, and its temperature."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from softhand_common.numerics.arrays import Array, Spools
from softhand_common.numerics.compiled import compiled
from softhand_model.gas import CRITICAL_RATIO, GAS_CONSTANT, HEAT_CAPACITY_RATIO

INLET, OUTLET = 0, 1  # rows of the arrays over flow paths
RATIO_EXPONENT = 1 / HEAT_CAPACITY_RATIO
FLOW_EXPONENT = HEAT_CAPACITY_RATIO / (HEAT_CAPACITY_RATIO - 1)
SMALLEST_FLOAT = float(np.finfo(float).tiny)
HEAT_CAPACITY = GAS_CONSTANT / (HEAT_CAPACITY_RATIO - 1)  # of air at constant volume [J/(kg K)]


class Paths(NamedTuple):
    """The inlet and outlet paths of `n` channels.

    Conductances of the chokes and of chokes with open valves (2, n) [kg/(s Pa)], of the lines
    (n,) [kg/(s Pa2)], and the capacity of one dead volume [kg/Pa].
    """

    choke: Array
    choke_and_valve: Array
    line: Array
    dead_capacity: float


class Contents(NamedTuple):
    """Air of `n` channels; a step changes these arrays in place.

    `air` (n,) in the actuators, `dead` (2, n) in the dead volumes, `inflow` and `outflow` (n,)
    through the valves since the start [kg]; in the last step, `received` (n,) [kg] that came into
    the actuators by any path, and `net_flow` (n,) [kg/s] through the lines into them.
    """

    air: Array
    dead: Array
    inflow: Array
    outflow: Array
    received: Array
    net_flow: Array


@compiled
def series_flow(high: float, low: float, orifice: float, line: float) -> float:
    """Mass flow [kg/s] through an orifice and a laminar line in series, zero without a drop.

    Their drops of squared pressure add, not their conductances: with the flow `f_o` that the
    orifice alone and `f_l` that the line alone would pass under the whole drop, the flow `f` is
    the root of `(f/f_o)**2 + f/f_l = 1`. Exact when either element dominates; in between the
    orifice's characteristic is taken as a parabola in squared pressure, which is at most 6 % off
    the exact solution (a choked orifice and a tube of like resistance).

    Args:
        high: absolute pressure upstream, not below `low` [Pa].
        low: absolute pressure downstream [Pa].
        orifice: conductance of `softhand_model.gas.orifice_conductance` [kg/(s Pa)].
        line: conductance of `softhand_model.gas.line_conductance` [kg/(s Pa2)].
    """
    ratio = min(max(low / high, CRITICAL_RATIO), 1.0)
    root = ratio**RATIO_EXPONENT
    psi = math.sqrt(FLOW_EXPONENT * root * (root - ratio))
    by_orifice = orifice * high * psi
    by_line = line * (high * high - low * low)
    total = by_orifice + math.sqrt(by_orifice * by_orifice + 4.0 * by_line * by_line)
    return 2.0 * by_orifice * by_line / max(total, SMALLEST_FLOAT)


@compiled
def move_air(
    dt: float,
    state: Spools,
    outer: tuple[float, float],
    capacity: Array,
    paths: Any,
    contents: Any,
    at_box: Array,
) -> float:
    """Let air flow for `dt` [s] with the spools held; changes `contents` and `at_box` in place.

    The dead volume of an open path takes the outer pressure at once. The flow through each choke is
    `series_flow`, limited to what equalises the pressures of its two sides, so that a step does not
    overshoot.

    Args:
        dt: step [s].
        state: spools (n,): +1 inflating, -1 deflating, 0 closed.
        outer: absolute pressure of supply and surroundings [Pa].
        capacity: air per pressure of the actuators (n,) [kg/Pa].
        paths, contents: the fields of `Paths` and of `Contents`.
        at_box: its first n entries become absolute pressures [Pa], at the box's end of each line.

    Returns:
        Mass that has left the supply [kg].
    """
    choke, choke_and_valve, line, dead_capacity = paths
    air, dead, inflow, outflow, received, net_flow = contents
    taken = 0.0
    for i in range(len(state)):
        pressure, net = air[i] / capacity[i], 0.0
        received[i] = 0.0
        for path in range(2):
            opened = state[i] > 0 if path == INLET else state[i] < 0
            through = 0.0
            if opened:
                through = outer[path] * dead_capacity - dead[path, i]
                dead[path, i] += through
            inner = dead[path, i] / dead_capacity
            high, low = max(inner, pressure), min(inner, pressure)
            orifice = choke_and_valve[path, i] if opened else choke[path, i]
            flow = series_flow(high, low, orifice, line[i])
            both = capacity[i] * dead_capacity / (capacity[i] + dead_capacity)
            most = (high - low) * (capacity[i] if opened else both)
            moved = math.copysign(min(flow * dt, most), inner - pressure)
            net += moved
            received[i] += max(moved, 0.0)
            if opened:
                through += moved
            else:
                dead[path, i] -= moved
            if path == INLET:
                inflow[i] += through
                taken += through
            else:
                outflow[i] -= through
        air[i] += net
        net_flow[i] = net / dt
        after = air[i] / capacity[i]
        at_box[i] = math.sqrt(max(after * after + net_flow[i] / line[i], 0.0))
    return taken


class ChannelHeat:
    """Temperature (n,) [K] of ideal, well-mixed air in `n` channels.

    First law for the air of a channel: `d(m c_v T) = c_p T_wall dm_in - c_p T dm_out - p dV -
    m c_v (T - T_wall)/tau dt`; air comes in at the temperature of the walls. Each term is taken in
    its exact solution, one after the other. `heat` counts what the walls have taken [J].

    Args:
        wall: temperature of walls, supply and surroundings [K].
        time_constants: `tau` (n,), in which the air takes on the wall's temperature [s].
    """

    def __init__(self, wall: float, time_constants: Array) -> None:
        self._wall, self._time_constants = wall, time_constants
        self.temperature: Array = np.full(len(time_constants), wall)
        self.heat: Array = np.zeros(len(time_constants))

    def compress(self, before: Array, after: Array) -> None:
        """Change the volumes (n,) [m3] without heat: `T V**(kappa - 1)` stays."""
        compress_air(before, after, self.temperature)

    def mix(self, dt: float, air: Array, received: Array, net: Array) -> None:
        """Let air in, then out, and then the walls take heat from it for `dt` [s].

        Args:
            dt: time of the exchange [s], 0 for none.
            air: in the channels, after it has moved (n,) [kg].
            received: air that came in (n,) [kg].
            net: air that came in less air that left (n,) [kg].
        """
        states = air, received, net, self.temperature, self.heat
        mix_air(dt, self._wall, self._time_constants, *states)

    def save(self) -> dict[str, Any]:
        """Return a copy of the changing state."""
        return {"temperature": self.temperature.copy(), "heat": self.heat.copy()}

    def restore(self, saved: dict[str, Any]) -> None:
        """Go back to what `save` returned."""
        self.temperature, self.heat = saved["temperature"].copy(), saved["heat"].copy()


@compiled
def compress_air(before: Array, after: Array, temperature: Array) -> None:
    """`ChannelHeat.compress`, of temperatures (n,) [K] in place."""
    for i in range(len(temperature)):
        if after[i] != before[i]:
            temperature[i] *= (before[i] / after[i]) ** (HEAT_CAPACITY_RATIO - 1)


@compiled
def mix_air(
    dt: float,
    wall: float,
    time_constants: Array,
    air: Array,
    received: Array,
    net: Array,
    temperature: Array,
    heat: Array,
) -> None:
    """`ChannelHeat.mix`, of temperatures (n,) [K] and of the walls' heat (n,) [J] in place."""
    for i in range(len(temperature)):
        before = air[i] - net[i]
        whole = before + received[i]
        if received[i] > 0:
            energy = before * temperature[i] + HEAT_CAPACITY_RATIO * received[i] * wall
            temperature[i] = energy / whole
        if air[i] != whole:  # what stays expands without heat
            temperature[i] *= (air[i] / whole) ** (HEAT_CAPACITY_RATIO - 1)
        if dt > 0:
            change = (temperature[i] - wall) * -math.expm1(-dt / time_constants[i])
            temperature[i] -= change
            heat[i] += HEAT_CAPACITY * air[i] * change
