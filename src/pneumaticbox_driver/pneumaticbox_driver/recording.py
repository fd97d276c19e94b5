"""Records test pulses on volumes that are known: the data acquisition of Algorithm 1."""

from collections.abc import Generator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pneumaticbox_driver.calibration import Pulse
from pneumaticbox_driver.pulse_integrals import PulseIntegrals
from pneumaticbox_driver.see_saw import SeeSaw
from softhand_model.gas import AMBIENT_PRESSURE, ROOM_TEMPERATURE, air_mass

Floats = NDArray[np.float64]
Valves = NDArray[np.int8]
SETTLING = 0.2  # after a pulse, for the valve and its dead volume [s]
AVERAGING = 0.2  # of the pressures before and after a pulse [s]


@dataclass(frozen=True)
class Sample:
    """A sensor sample: stamp [s], absolute pressures of the channels and of the supply [Pa]."""

    time: float
    pressures: Floats
    supply: float


Recording = Generator[Valves, Sample, list[list[Pulse]]]


def record_pulses(see_saw: SeeSaw, channels: int, cycles: int, volume: float) -> Recording:
    """Inflate and deflate all channels `cycles` times, as a coroutine of samples.

    It yields valves (channels,), wants the next `Sample` sent, and returns the recorded pulses
    per channel. It starts with all channels at ambient pressure, where it zeroes their sensors.
    The ground truth of a pulse is `dm = dp V/(R_s T)`.

    Args:
        see_saw: draws the durations.
        channels: number of channels.
        cycles: pulses per direction.
        volume: of the fixed volume on each channel [m3].
    """
    pulses: list[list[Pulse]] = [[] for _ in range(channels)]
    offsets = (yield from _average(channels, 2 * AVERAGING)) - AMBIENT_PRESSURE
    for _ in range(cycles):
        gauge = (yield from _average(channels, AVERAGING)) - offsets - AMBIENT_PRESSURE
        inflation, deflation = see_saw.next(gauge)
        for direction, durations in ((1, inflation), (-1, deflation)):
            recorded = yield from _pulse(direction, durations, offsets, volume)
            for channel, pulse in enumerate(recorded):
                pulses[channel].append(pulse)
    return pulses


def _average(channels: int, duration: float) -> Generator[Valves, Sample, Floats]:
    """Mean pressures over a duration [s], valves closed (channels,) [Pa]."""
    closed = np.zeros(channels, dtype=np.int8)
    sample = yield closed
    start, total, count = sample.time, sample.pressures.copy(), 1
    while sample.time - start < duration:
        sample = yield closed
        total += sample.pressures
        count += 1
    return total / count


def _pulse(
    direction: int, durations: Floats, offsets: Floats, volume: float
) -> Generator[Valves, Sample, list[Pulse]]:
    """One pulse on every channel, each of its own duration (n,) [s]."""
    n = len(durations)
    before = (yield from _average(n, AVERAGING)) - offsets
    integrals, lengths = yield from _open(direction, durations, offsets)
    yield from _average(n, SETTLING)
    after = (yield from _average(n, AVERAGING)) - offsets
    moved = direction * air_mass(after - before, volume, ROOM_TEMPERATURE)
    return [
        Pulse(direction > 0, float(lengths[i]), *integrals.values[1:, i].tolist(), float(moved[i]))
        for i in range(n)
    ]


def _open(
    direction: int, durations: Floats, offsets: Floats
) -> Generator[Valves, Sample, tuple[PulseIntegrals, Floats]]:
    """Open all valves, close each after its duration; returns integrals and true lengths [s]."""
    n = len(durations)
    sample = yield np.zeros(n, dtype=np.int8)
    valves = np.full(n, direction, dtype=np.int8)
    integrals = PulseIntegrals(n)
    integrals.begin(np.ones(n, dtype=bool), valves, sample.pressures - offsets, sample.supply)
    lengths, start = np.zeros(n), sample.time
    done = integrals.values.copy()
    while valves.any():
        before = sample.time
        sample = yield valves
        integrals.advance(sample.time - before, sample.pressures - offsets, sample.supply)
        done = np.where(valves != 0, integrals.values, done)
        lengths = np.where(valves != 0, sample.time - start, lengths)
        still_open = lengths < durations - 1e-6
        valves = np.where(still_open, valves, 0).astype(np.int8)
    integrals.values = done
    return integrals, lengths
