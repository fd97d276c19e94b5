"""Records test pulses on volumes that are known: the data acquisition of Algorithm 1."""

from collections.abc import Generator
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pneumaticbox_driver.pulse_integrals import PulseIntegrals
from pneumaticbox_driver.regression import Pulse
from pneumaticbox_driver.see_saw import SeeSaw
from softhand_model.gas import AMBIENT_PRESSURE, ROOM_TEMPERATURE, air_mass

Floats = NDArray[np.float64]
Valves = NDArray[np.int8]
SETTLING = 0.2  # after a pulse, for the valve and its dead volume [s]
AVERAGING = 0.2  # of the pressures between two pulses [s]
CEILING = 200e3  # gauge: within the sensors' range, pulses end there [Pa]


@dataclass(frozen=True)
class Sample:
    """A sensor sample: stamp [s], absolute pressures of the channels and of the supply [Pa]."""

    time: float
    pressures: Floats
    supply: float


Recording = Generator[Valves, Sample, list[list[Pulse]]]
Step = Generator[Valves, Sample, None]


@dataclass(frozen=True)
class Rest:
    """Pressures between two pulses: middle of the window [s], means [Pa], their variances [Pa2].

    The pressures are absolute, as the sensors read them (n,).
    """

    time: float
    mean: Floats
    variance: Floats


def record_pulses(see_saw: SeeSaw, channels: int, cycles: int, volume: float) -> Recording:
    """Inflate and deflate all channels `cycles` times, as a coroutine of samples.

    It yields valves (channels,), wants the next `Sample` sent, and returns the recorded pulses
    per channel. It starts with all channels at ambient pressure, where it zeroes their sensors.

    Args:
        see_saw: draws the durations.
        channels: number of channels.
        cycles: pulses per direction.
        volume: of the fixed volume on each channel [m3].
    """
    recorder = PulseRecorder(channels, volume)
    yield from recorder.zero()
    for _ in range(cycles):
        yield from recorder.cycle(see_saw)
    return recorder.pulses


class PulseRecorder:
    """Plays test pulses on all channels at once and keeps what they did.

    The ground truth of a pulse is `dm = dp V/(R_s T)`, from the pressures averaged before and
    after it; the average after one pulse is that before the next.

    Args:
        channels: number of channels.
        volumes: of the fixed volumes (n,), or one for all [m3].
        settling: between the end of the pulses and the average [s].
        averaging: length of the average [s].
        ceiling: gauge pressure at which a pulse ends [Pa].
    """

    def __init__(
        self,
        channels: int,
        volumes: ArrayLike,
        settling: float = SETTLING,
        averaging: float = AVERAGING,
        ceiling: float = CEILING,
    ) -> None:
        self.pulses: list[list[Pulse]] = [[] for _ in range(channels)]
        self.offsets: Floats = np.zeros(channels)  # of the sensors [Pa]
        self.rest = Rest(0.0, np.full(channels, AMBIENT_PRESSURE), np.zeros(channels))
        self._n = channels
        self._volumes = np.broadcast_to(np.asarray(volumes, dtype=float), channels)
        self._settling, self._averaging, self._ceiling = settling, averaging, ceiling

    @property
    def gauge(self) -> Floats:
        """Gauge pressures after the last pulse (n,) [Pa]."""
        return self.rest.mean - self.offsets - AMBIENT_PRESSURE

    def zero(self) -> Step:
        """Take the pressures as they are for ambient: they give the offsets of the sensors."""
        self.rest = yield from average(self._n, 2 * self._averaging)
        self.offsets = self.rest.mean - AMBIENT_PRESSURE

    def cycle(self, see_saw: SeeSaw) -> Step:
        """Inflate every channel once, then deflate it once."""
        inflation, deflation = see_saw.next(self.gauge)
        for direction, durations in ((1, inflation), (-1, deflation)):
            yield from self._pulse(direction, durations)

    def _pulse(self, direction: int, durations: Floats) -> Step:
        """One pulse on every channel, each of its own duration (n,) [s]."""
        before = self.rest
        integrals = yield from self._play(direction, durations)
        yield from hold(self._n, self._settling)
        self.rest = after = yield from average(self._n, self._averaging)
        capacity = air_mass(1.0, self._volumes, ROOM_TEMPERATURE)  # [kg/Pa]
        moved = direction * capacity * (after.mean - before.mean)
        noise = capacity * np.sqrt(before.variance + after.variance)
        gauge = 0.5 * (before.mean + after.mean) - self.offsets - AMBIENT_PRESSURE
        exposure = gauge * (after.time - before.time)
        columns = np.array([integrals.lengths, *integrals.values[1:], moved, noise, exposure])
        for pulses, column in zip(self.pulses, columns.T.tolist(), strict=True):
            pulses.append(Pulse(direction > 0, *column))

    def _play(self, direction: int, durations: Floats) -> Generator[Valves, Sample, PulseIntegrals]:
        """Open all valves, close each after its duration (n,) [s]; returns the regressors."""
        closed = np.zeros(self._n, dtype=np.int8)
        sample = yield closed
        valves = np.full(self._n, direction, dtype=np.int8)
        integrals = PulseIntegrals(self._n)
        integrals.begin(valves != 0, valves, sample.pressures - self.offsets, sample.supply)
        kept = integrals.values.copy()
        while (flowing := integrals.flowing).any():
            before = sample.time
            sample = yield valves
            pressures = sample.pressures - self.offsets
            integrals.advance(sample.time - before, pressures, sample.supply)
            kept = np.where(flowing, integrals.values, kept)
            full = direction * (pressures - AMBIENT_PRESSURE) > self._ceiling
            ended = (integrals.lengths > durations - 1e-6) | full
            integrals.end(ended)
            valves = np.where(ended, 0, valves).astype(np.int8)
        integrals.values = kept
        return integrals


def hold(channels: int, duration: float) -> Step:
    """Keep all valves closed for a duration [s]."""
    yield from average(channels, duration)


def average(channels: int, duration: float) -> Generator[Valves, Sample, Rest]:
    """Pressures over a duration [s], valves closed."""
    closed = np.zeros(channels, dtype=np.int8)
    sample = yield closed
    start, total, squares, count = sample.time, np.zeros(channels), np.zeros(channels), 0
    reference = sample.pressures
    while True:
        change = sample.pressures - reference
        total += change
        squares += change**2
        count += 1
        if sample.time - start >= duration:
            break
        sample = yield closed
    mean = total / count
    scatter = np.maximum(squares / count - mean**2, 0.0) / max(count - 1, 1)
    return Rest(0.5 * (start + sample.time), reference + mean, scatter)
