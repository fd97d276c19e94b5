"""The pneumatic plant with its flow step compiled: the same physics, four times faster.

Import `PLANT` from here: with numba it is the compiled plant; without, the numpy step of
`softhand_model.pneumatics.plant` is the faster one and stays.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from softhand_model.gas import CRITICAL_RATIO, HEAT_CAPACITY_RATIO
from softhand_model.numerics.compiled import COMPILED, compiled
from softhand_model.pneumatics.air_flow import IN
from softhand_model.pneumatics.plant import PneumaticPlant

Floats = NDArray[np.float64]
ROOT = 1 / HEAT_CAPACITY_RATIO
EXPONENT = HEAT_CAPACITY_RATIO / (HEAT_CAPACITY_RATIO - 1)
TINY = float(np.finfo(float).tiny)


@compiled
def compiled_move_air(
    dt: float,
    state: NDArray[np.int8],
    outer: tuple[float, float],
    capacity: Floats,
    dead_capacity: float,
    paths: Any,
    contents: Any,
    at_box: Floats,
) -> float:
    """Let air flow for `dt` [s]: `air_flow.move_air`, channel by channel."""
    choke, choke_and_valve, line = paths
    air, dead, inflow, outflow, received, net_flow = contents
    taken = 0.0
    for i in range(len(state)):
        pressure, net = air[i] / capacity[i], 0.0
        received[i] = 0.0
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
            received[i] += max(moved, 0.0)
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


class CompiledPlant(PneumaticPlant):
    """`PneumaticPlant` whose air flows in a compiled loop over channels."""

    _move_air = staticmethod(compiled_move_air)


PLANT = CompiledPlant if COMPILED else PneumaticPlant
