"""Recording of test pulses on known volumes (Algorithm 1), and the leak test (section 4.4.4)."""

import math
from collections.abc import Generator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from pneumaticbox_driver.arrays import Floats, Valves
from pneumaticbox_driver.calibration.regression import Pulse
from pneumaticbox_driver.calibration.valve_delays import PulseTrace, valve_delays
from pneumaticbox_driver.observer.coefficients import VALVE_DELAY, Leak
from pneumaticbox_driver.observer.pulses import PulseIntegrals
from softhand_model.gas import AMBIENT_PRESSURE, ROOM_TEMPERATURE, air_mass

PULSE_SETTLING = 0.2  # wait after a pulse, for the valve and its dead volume [s]
AVERAGING = 0.2  # of the pressures between two pulses [s]
CLOSING = 0.085  # after the last switch-off, time in which its valve has closed [s]
PULSE_CEILING = 200e3  # gauge pressure at which pulses end, within the sensors' range [Pa]
SIGNIFICANT_LEAK = 3.0  # standard errors
LEAK_WINDOWS = 12  # averages of the pressure to which the slope is fitted


@dataclass(frozen=True)
class PulseRanges:
    """Ranges of Algorithm 1: durations [s], gauge channel pressures [Pa], skew and speeds.

    `mean_duration` [s] is the scale of the exponential distribution, `speed_ratio` the speed of
    deflation over that of inflation [-]. The thesis has a skew factor of 2 for 400 points and more.
    With only 100 points a bottle of 0.5 L needs a larger factor to go through the pressure range;
    the longest pulses then move it up or down, and all others can be as short as in control.
    """

    shortest: float = 0.045  # just above the slowest opening delay; shorter ones may move no air
    longest: float = 1.5
    mean_duration: float = 0.18
    low_pressure: float = 3e3
    high_pressure: float = 60e3
    skew_factor: float = 25.0
    speed_ratio: float = 4.0


class PulseDurations:
    """Draws pulse durations that move each channel up and down through its pressure range.

    ERRATUM: Algorithm 1 has the inverse of the speed ratio; here the faster deflation gets the
    shorter pulses, `t_deflation = t/skew * inflation_speed/deflation_speed`.

    Args:
        plan: ranges of Algorithm 1.
        channels: number of channels; each has its own durations.
        seed: seed of the durations.
    """

    def __init__(self, plan: PulseRanges, channels: int, seed: int) -> None:
        self._plan = plan
        self._random = np.random.default_rng(seed)
        self._skew: Floats = np.full(channels, math.sqrt(plan.skew_factor))

    def next(self, pressures: Floats) -> tuple[Floats, Floats]:
        """Draw the next durations of inflation and deflation (n,), (n,) [s].

        Args:
            pressures: present channel pressures (n,) [Pa].
        """
        plan = self._plan
        up = math.sqrt(plan.skew_factor)
        self._skew = np.where(pressures < plan.low_pressure, up, self._skew)
        self._skew = np.where(pressures > plan.high_pressure, 1 / up, self._skew)
        span = plan.longest - plan.shortest
        uniform = self._random.uniform(size=len(pressures))
        drawn = -plan.mean_duration * np.log1p(-uniform * -math.expm1(-span / plan.mean_duration))
        # the shortest pulse is a property of the valve and not scaled by the skew
        inflation = plan.shortest + drawn * self._skew
        return inflation, plan.shortest + drawn / self._skew / plan.speed_ratio


@dataclass(frozen=True)
class Sample:
    """A sensor sample: stamp [s], absolute pressures of the channels and of the supply [Pa]."""

    time: float
    pressures_abs: Floats
    supply_abs: float

    @classmethod
    def of(cls, time: float, readings: Floats) -> "Sample":
        """Make a sample of absolute pressures, the supply's last (n + 1,) [Pa]."""
        return cls(time, readings[:-1], float(readings[-1]))


Recording = Generator[Valves, Sample, list[list[Pulse]]]
Step = Generator[Valves, Sample, None]


@dataclass(frozen=True)
class Rest:
    """Absolute pressures between two pulses: middle of the averaging window [s], means (n,) [Pa],
    variances of the means (n,) [Pa2] and the number of samples.
    """

    time: float
    mean: Floats
    variance: Floats
    count: int


def record_pulses(
    durations: PulseDurations,
    channels: int,
    cycles: int,
    volume: float,
    settling: float = PULSE_SETTLING,
) -> Recording:
    """Inflate and deflate all channels `cycles` times, as a generator.

    It yields valves (channels,), receives the next `Sample`, and returns the recorded pulses per
    channel. All channels must be at ambient pressure at first, where their sensors are zeroed.

    Args:
        durations: draws the durations of the pulses.
        channels: number of channels.
        cycles: pulses per direction.
        volume: fixed volume on each channel [m3].
        settling: time between the end of the pulses and the average [s].
    """
    recorder = PulseRecorder(channels, volume, settling)
    yield from recorder.zero()
    for _ in range(cycles):
        yield from recorder.cycle(durations)
    return recorder.pulses()


@dataclass(frozen=True)
class PlayedPulse:
    """Record of a pulse on all channels.

    `direction` is +1 or -1, `lengths` (n,) are those of the commands [s], `times` (samples,) from
    switch-on [s], `pressures_abs` (samples, n) without the offsets of the sensors and `supply_abs`
    (samples,) in [Pa], `before` and `after` the averaged pressures.
    """

    direction: int
    lengths: Floats
    times: Floats
    pressures_abs: Floats
    supply_abs: Floats
    before: Rest
    after: Rest


class PulseRecorder:
    """Carries out test pulses on all channels at once and records them.

    The true mass of a pulse is `dm = dp V/(R_s T)`, from the pressures averaged before and after
    it; the average after one pulse is that before the next.

    Args:
        channels: number of channels.
        volumes: fixed volumes on the channels (n,), or one for all [m3].
        settling: time between the end of the pulses and the average [s].
        averaging: length of the average [s].
        ceiling: gauge pressure at which a pulse ends [Pa].
    """

    def __init__(
        self,
        channels: int,
        volumes: ArrayLike,
        settling: float = PULSE_SETTLING,
        averaging: float = AVERAGING,
        ceiling: float = PULSE_CEILING,
    ) -> None:
        self.offsets: Floats = np.zeros(channels)  # of the sensors [Pa]
        self.rest = Rest(0.0, np.full(channels, AMBIENT_PRESSURE), np.zeros(channels), 1)
        self._n = channels
        self._volumes = np.broadcast_to(np.asarray(volumes, dtype=float), channels)
        self._settling, self._averaging, self._ceiling = settling, averaging, ceiling
        self._played: list[PlayedPulse] = []

    @property
    def pressures(self) -> Floats:
        """Gauge pressures after the last pulse (n,) [Pa]."""
        return self.rest.mean - AMBIENT_PRESSURE

    def zero(self) -> Step:
        """Steps that measure the offsets of the sensors, with all channels at ambient pressure."""
        reading = yield from average(self._n, 2 * self._averaging)
        self.offsets = reading.mean - AMBIENT_PRESSURE
        self.rest = self._without_offset(reading)

    def cycle(self, durations: PulseDurations) -> Step:
        """Inflate every channel once, then deflate it once."""
        inflation, deflation = durations.next(self.pressures)
        for direction, lasting in ((1, inflation), (-1, deflation)):
            before = self.rest
            lengths, samples = yield from self._play(direction, lasting)
            yield from average(self._n, self._settling)
            reading = yield from average(self._n, self._averaging)
            self.rest = self._without_offset(reading)
            times = np.array([sample.time for sample in samples])
            played = PlayedPulse(
                direction,
                lengths,
                times - times[0],
                np.array([sample.pressures_abs for sample in samples]) - self.offsets,
                np.array([sample.supply_abs for sample in samples]),
                before,
                self.rest,
            )
            self._played.append(played)

    def _without_offset(self, rest: Rest) -> Rest:
        return replace(rest, mean=rest.mean - self.offsets)

    def _play(
        self, direction: int, durations: Floats
    ) -> Generator[Valves, Sample, tuple[Floats, list[Sample]]]:
        """Open all valves, close each after its duration (n,) [s].

        Returns the lengths of the pulses (n,) [s] and the samples from switch-on until all
        valves must have closed.
        """
        samples = [(yield np.zeros(self._n, dtype=np.int8))]
        start = samples[0].time
        valves = np.full(self._n, direction, dtype=np.int8)
        lengths: Floats = np.zeros(self._n)
        while samples[-1].time - start - lengths.max() < CLOSING or valves.any():
            sample = yield valves
            samples.append(sample)
            lengths = np.where(valves != 0, sample.time - start, lengths)
            pressures = sample.pressures_abs - self.offsets - AMBIENT_PRESSURE
            ended = (lengths > durations - 1e-6) | (direction * pressures > self._ceiling)
            valves = np.where(ended, 0, valves).astype(np.int8)
        return lengths, samples

    # evaluation

    def pulses(self) -> list[list[Pulse]]:
        """The recorded pulses per channel, with integrals for the measured valve delays."""
        result: list[list[Pulse]] = [[] for _ in range(self._n)]
        delays = {direction: self._delays(direction) for direction in (1, -1)}
        for played in self._played:
            for pulses, pulse in zip(
                result, self._read(played, delays[played.direction]), strict=True
            ):
                pulses.append(pulse)
        return result

    def _delays(self, direction: int) -> Floats:
        """Delays of opening and closing in one direction (2, n) [s]."""
        played = [p for p in self._played if p.direction == direction]
        if not played:
            return np.full((2, self._n), VALVE_DELAY)
        noise = [np.sqrt(np.mean([p.after.variance * p.after.count for p in played], axis=0))]
        return np.array(
            [
                valve_delays([trace_of(p, channel) for p in played], float(noise[0][channel]))
                for channel in range(self._n)
            ]
        ).T

    def _read(self, played: PlayedPulse, delays: Floats) -> list[Pulse]:
        values = integrals_of(played, delays)
        before, after = played.before, played.after
        capacity = air_mass(1.0, self._volumes, ROOM_TEMPERATURE)  # [kg/Pa]
        moved = played.direction * capacity * (after.mean - before.mean)
        noise = capacity * np.sqrt(before.variance + after.variance)
        pressures = 0.5 * (before.mean + after.mean) - AMBIENT_PRESSURE
        exposure = pressures * (after.time - before.time)
        columns = np.array([played.lengths, *values[1:], moved, noise, exposure])
        return [
            replace(Pulse(played.direction > 0, *column), delays=(opening, closing))
            for column, (opening, closing) in zip(
                columns.T.tolist(), delays.T.tolist(), strict=True
            )
        ]


def trace_of(played: PlayedPulse, channel: int) -> PulseTrace:
    """The pressure of one channel during a pulse."""
    return PulseTrace(
        played.times,
        played.pressures_abs[:, channel],
        float(played.lengths[channel]),
        float(played.before.mean[channel]),
        float(played.after.mean[channel]),
        played.direction,
    )


def integrals_of(played: PlayedPulse, delays: Floats) -> Floats:
    """Regressors of equation 4.1 of a pulse on every channel (5, n).

    Args:
        played: record of the pulse.
        delays: delays of opening and closing (2, n) [s].
    """
    n = len(played.lengths)
    integrals = PulseIntegrals(n)
    every = np.ones(n, dtype=bool)
    valves = np.full(n, played.direction, dtype=np.int8)
    pressures_abs, supply_abs = played.pressures_abs, played.supply_abs
    integrals.begin(every, valves, pressures_abs[0], float(supply_abs[0]), delays)
    for k in range(1, len(played.times)):
        step = float(played.times[k] - played.times[k - 1])
        integrals.advance(step, pressures_abs[k], float(supply_abs[k]))
        integrals.end(integrals.lengths > played.lengths - 1e-6)
    return integrals.values


def average(channels: int, duration: float) -> Generator[Valves, Sample, Rest]:
    """Average the pressures over a duration [s] with closed valves."""
    closed = np.zeros(channels, dtype=np.int8)
    sample = yield closed
    start, total, squares, count = sample.time, np.zeros(channels), np.zeros(channels), 0
    reference = sample.pressures_abs
    while True:
        change = sample.pressures_abs - reference
        total += change
        squares += change**2
        count += 1
        if sample.time - start >= duration:
            break
        sample = yield closed
    mean = total / count
    scatter = np.maximum(squares / count - mean**2, 0.0) / max(count - 1, 1)
    return Rest(0.5 * (start + sample.time), reference + mean, scatter, count)


def measure_leaks(
    volumes: Floats, offsets: Floats, duration: float
) -> Generator[Valves, Sample, list[Leak]]:
    """Measure the leaks of closed channels under pressure.

    The slope of the pressure gives the conductance, `k = -dp/dt V/(R_s T)/p_gauge`.

    Args:
        volumes: fixed volumes on the channels (n,) [m3].
        offsets: offsets of the sensors (n,) [Pa].
        duration: duration of the measurement [s].

    Returns:
        The leak of each channel; 0 below three standard errors, and without pressure.
    """
    rests = []
    for _ in range(LEAK_WINDOWS):
        rests.append((yield from average(len(volumes), duration / LEAK_WINDOWS)))
    capacities = air_mass(1.0, volumes, ROOM_TEMPERATURE).tolist()
    return [
        _leak(rests, channel, capacity, float(offsets[channel]))
        for channel, capacity in enumerate(capacities)
    ]


def _leak(rests: list[Rest], channel: int, capacity: float, offset: float) -> Leak:
    time = np.array([rest.time for rest in rests])
    pressures_abs = np.array([rest.mean[channel] for rest in rests])
    variance = np.mean([rest.variance[channel] for rest in rests])
    pressure = pressures_abs.mean() - offset - AMBIENT_PRESSURE
    if pressure < 1e3:
        return Leak()
    centred = time - time.mean()
    per_slope = capacity / pressure
    slope = centred @ pressures_abs / (centred @ centred)
    error = per_slope * float(np.sqrt(variance / (centred @ centred)))
    conductance = -per_slope * float(slope)
    return Leak(conductance if conductance > SIGNIFICANT_LEAK * error else 0.0, error)
