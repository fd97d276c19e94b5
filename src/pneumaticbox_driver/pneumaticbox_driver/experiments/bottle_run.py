"""A run of the box on the pretended bench, and what is kept of it."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from pneumaticbox_driver.backends.embedded import EmbeddedBench
from pneumaticbox_driver.box import PneumaticBox
from pneumaticbox_driver.calibration import ChannelCalibration
from pneumaticbox_driver.commands import TrajectoryPoint
from pneumaticbox_driver.experiments.boxes import BOTTLE, OUTLETS, PERIOD
from pneumaticbox_driver.experiments.report import Floats, Progress, Series, option
from pneumaticbox_driver.settings import BoxSettings
from softhand_model.gas import GAS_CONSTANT, ROOM_TEMPERATURE
from softhand_model.pneumatics import Pneumatics

PRESSURE_LIMIT = 2e5  # gauge: within the sensors' range [Pa]
SETTLING = 0.1  # after a valve was closed, before its channel's pressure is taken [s]
KEPT_EVERY = 10  # samples
HOLD = 1.0  # after a sine, so that the last pulse is over and the pressure known [s]
Supply = Callable[[float], float]  # gauge pressure of the regulator [Pa] at a time [s]


@dataclass(frozen=True)
class Sine:
    """Targets of air mass: a step from rest, later `mean - amplitude cos`, then its last value.

    The defaults are such that the box needs about the 122 pulses of Fig. 4.9 for them, on a
    bottle at about the pressure at which a finger works.
    """

    duration: float = option(60.0, "time of the sine [s]")
    mean: float = option(150e-6, "mean air mass of the sine above the fill at rest [kg]")
    amplitude: float = option(20e-6, "amplitude of the sine [kg]")
    period: float = option(20.0, "period of the sine [s]")
    fill: float = option(8.0, "time to fill the channels to where the sine starts [s]")

    def __post_init__(self) -> None:
        for name in ("duration", "period", "fill"):
            if not getattr(self, name) > 0:
                raise ValueError(f"{name} must be above 0 s, got {getattr(self, name)}")
        if not 0 < self.amplitude < self.mean:
            # a target of zero empties the channel and tares it
            got = f"{self.amplitude} and {self.mean}"
            raise ValueError(f"amplitude must be above 0 kg and below the mean, got {got}")

    @property
    def end(self) -> float:
        """When the sine is over, counted from the step at rest [s]."""
        return self.fill + self.duration

    def at(self, time: Floats) -> Floats:
        """Targets at times counted from the step at rest [s], in the times' shape [kg]."""
        phase = 2 * np.pi * (np.clip(time, self.fill, self.end) - self.fill) / self.period
        return np.asarray(self.mean - self.amplitude * np.cos(phase))

    def trajectory(self, channels: int) -> list[TrajectoryPoint]:
        """The command for all channels, a point every 50 ms."""
        times = np.arange(round(self.end / 0.05) + 1) * 0.05
        return [
            TrajectoryPoint(float(time), [float(mass)] * channels)
            for time, mass in zip(times, self.at(times), strict=True)
        ]


@dataclass
class Record:
    """Samples of a run that were kept, oldest first; per channel (n,) each."""

    time: list[float] = field(default_factory=list)
    estimate: list[Floats] = field(default_factory=list)
    truth: list[Floats] = field(default_factory=list)
    measured: list[Floats] = field(default_factory=list)
    pulses: list[NDArray[np.int_]] = field(default_factory=list)
    supply: list[float] = field(default_factory=list)
    gauge: list[Floats] = field(default_factory=list)

    def as_series(self) -> Series:
        """The samples as arrays (samples,) and (samples, channels)."""
        return {name: np.array(values, dtype=float) for name, values in vars(self).items()}


class BottleRun:
    """The box on bottles of the pretended bench, started and tared at rest.

    `measured` is the thesis's ground truth, `dp V/(R T)` of the sensors in between pulses, NaN
    while a valve is open or has just been closed; `truth` is the mass that the plant has gained,
    with none of the sensors' errors.

    Args:
        constants: of the plant.
        calibrations: one a channel.
        seed: of noise and jitter.
        volume: of the bottles [m3].
        shortest: pulse and pause that the box keeps [s]; None for its defaults.
    """

    def __init__(
        self,
        constants: Pneumatics,
        calibrations: Sequence[ChannelCalibration],
        seed: int,
        volume: float = BOTTLE,
        shortest: tuple[float, float] | None = None,
    ) -> None:
        n = len(calibrations)
        self.names = tuple(OUTLETS[:n])
        timing = {} if shortest is None else dict(zip(TIMING, shortest, strict=True))
        settings = BoxSettings(
            self.names, (volume,) * n, (PRESSURE_LIMIT,) * n, ("mass",) * n, **timing
        )
        self.box = PneumaticBox(settings, calibrations)
        self.bench = EmbeddedBench(self.names, np.full(n, volume), constants, seed)
        self.record = Record()
        self._capacity = volume / (GAS_CONSTANT * ROOM_TEMPERATURE)
        self._closed_since: Floats = np.zeros(n)
        self._sum: Floats = np.zeros(n)
        self._count: Floats = np.zeros(n)
        self._pulses: NDArray[np.int_] = np.zeros(n, dtype=int)
        while not self.box.ready:
            self._sample()

    def follow(self, sine: Sine, progress: Progress, supply: Supply | None = None) -> Series:
        """Command a sine and record it, and the second after it.

        Args:
            sine: targets of all channels.
            progress: is told.
            supply: gauge pressure of the regulator [Pa] over the time since the start [s]; None
                leaves it alone.

        Returns:
            The record, `time` [s] and `supply` [Pa] (samples,), the others (samples, channels),
            and the `target` (samples,) [kg].
        """
        start = self.box.time
        self._sum[:] = self._count[:] = 0.0  # of before the sensors were zeroed
        self.box.command(self.names, sine.trajectory(len(self.names)), 0.0, start)
        count = round((sine.end + HOLD) / PERIOD)
        for k in range(count):
            if supply is not None:
                self.bench.plant.set_supply(supply(k * PERIOD))
            self._sample()
            if k % KEPT_EVERY == 0:
                self._keep(self.box.time - start)
            if k % 1000 == 0:
                progress("sine", k / count)
        self._keep(self.box.time - start)
        series = self.record.as_series()
        return {**series, "target": sine.at(series["time"])}

    def _sample(self) -> None:
        readings = self.bench.advance(PERIOD)
        before = self.box.valves
        valves = self.box.on_sample(self.bench.time, readings)
        self.bench.command(valves)
        opened = (valves != before) & (valves != 0)
        self._pulses += opened
        moving = (valves != 0) | (before != 0)
        self._closed_since = np.where(moving, self.bench.time, self._closed_since)
        settled = self.bench.time - self._closed_since > SETTLING
        self._sum = np.where(settled, self._sum + self.box.gauge, 0.0)
        self._count = np.where(settled, self._count + 1.0, 0.0)

    def _keep(self, time: float) -> None:
        keep = self.record
        mean = np.full_like(self._sum, np.nan)
        np.divide(self._sum, self._count, out=mean, where=self._count > 0)
        keep.time.append(time)
        keep.estimate.append(self.box.observer.mass.copy())
        keep.truth.append(self.bench.mass)
        keep.measured.append(mean * self._capacity)
        keep.pulses.append(self._pulses.copy())
        keep.supply.append(self.box.supply)
        keep.gauge.append(self.box.gauge.copy())


TIMING = ("shortest_pulse", "shortest_pause")
