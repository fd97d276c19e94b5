"""What the valves can do: the mass of the smallest pulse, and the flow of an open inlet."""

import numpy as np

from pneumaticbox_driver.backends.embedded import EmbeddedBench
from pneumaticbox_driver.experiments.boxes import BOTTLE, OUTLETS, PERIOD
from pneumaticbox_driver.experiments.report import Floats
from softhand_model.gas import air_mass
from softhand_model.pneumatics import Pneumatics

WORKING = 25e3  # gauge pressure in the channels, about a finger's [Pa]
WAITING = 0.5  # after a pulse, so that its dead volume has emptied, and the regulator rests [s]
OPEN = 0.5  # of the pulse that the flow is taken from [s]
SETTLED = 0.1  # of it, before the flow is steady [s]


def smallest_steps(
    constants: Pneumatics, channels: int, pulse: float, seed: int, repeats: int = 5
) -> Floats:
    """Mass that pulses move on bottles at working pressure, by the plant's truth.

    Args:
        constants: of the plant.
        channels: number of outlets.
        pulse: duration of the electrical command [s].
        seed: of the jitter.
        repeats: pulses that are averaged.

    Returns:
        What an inflating pulse brings and what a deflating one takes (2, channels) [kg].
    """
    bench = _at_work(constants, channels, seed)
    moved = np.zeros((2, channels))
    for _ in range(repeats):
        for row, direction in enumerate((1, -1)):
            before = bench.mass
            _hold(bench, direction, pulse)
            _hold(bench, 0, WAITING)
            moved[row] += direction * (bench.mass - before)
    return moved / repeats


def inlet_flows(constants: Pneumatics, channels: int, seed: int) -> Floats:
    """Steady mass flow into bottles at working pressure, inlets open (channels,) [kg/s].

    One inlet is open at a time: the regulator gives way under the flow of many.
    """
    flows = np.zeros(channels)
    for channel in range(channels):
        bench = _at_work(constants, channels, seed)
        alone = np.zeros(channels)
        alone[channel] = 1
        _hold(bench, alone, SETTLED)
        before = bench.mass
        _hold(bench, alone, OPEN - SETTLED)
        flows[channel] = (bench.mass - before)[channel] / (OPEN - SETTLED)
    return flows


def _at_work(constants: Pneumatics, channels: int, seed: int) -> EmbeddedBench:
    bench = EmbeddedBench(OUTLETS[:channels], np.full(channels, BOTTLE), constants, seed)
    bench.plant.fill(bench.plant.mass + air_mass(WORKING, BOTTLE))
    _hold(bench, 0, WAITING)
    return bench


def _hold(bench: EmbeddedBench, valves: Floats | int, duration: float) -> None:
    """Command valves for a time [s]."""
    for _ in range(round(duration / PERIOD)):
        bench.command(np.broadcast_to(np.asarray(valves), (len(bench.mass),)))
        bench.advance(PERIOD)
