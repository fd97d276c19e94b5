"""A run of the box on the pretended bench, and what is kept of it."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from pneumaticbox_driver.backends.embedded import EmbeddedBench
from pneumaticbox_driver.box import PneumaticBox
from pneumaticbox_driver.calibration import ChannelCalibration
from pneumaticbox_driver.experiments.boxes import BOTTLE, OUTLETS, PERIOD
from pneumaticbox_driver.experiments.report import Floats, Progress, Series
from pneumaticbox_driver.experiments.sine import Sine
from pneumaticbox_driver.settings import BoxSettings
from softhand_model.gas import air_mass
from softhand_model.pneumatics import Pneumatics

PRESSURE_LIMIT = 2e5  # gauge: within the sensors' range [Pa]
SETTLING = 0.1  # after a valve was closed, before its channel's pressure is taken [s]
KEPT_EVERY = 10  # samples
HOLD = 1.0  # after a sine, so that the last pulse is over and the pressure known [s]
Supply = Callable[[float], float]  # gauge pressure of the regulator [Pa] at a time [s]
MassOf = Callable[[Floats], Floats]  # air above the fill at rest [kg] at gauge pressures [Pa]
TIMING = ("shortest_pulse", "shortest_pause")


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


class BenchRun:
    """The box on the pretended bench, started and tared at rest.

    `measured` is the thesis's ground truth, the mass by the sensors in between pulses, NaN while
    a valve is open or has just been closed; `truth` is the mass that the plant has gained, with
    none of the sensors' errors.

    Args:
        box: the driver's.
        bench: the plant's.
        mass_of: mass by the pressures, on bottles `dp V/(R T)`.
        sensor_offset: that the channels' sensors have besides their own errors [Pa].
    """

    def __init__(
        self,
        box: PneumaticBox,
        bench: EmbeddedBench,
        mass_of: MassOf,
        sensor_offset: float = 0.0,
    ) -> None:
        n = len(box.settings.channels)
        self.box, self.bench, self.record = box, bench, Record()
        self._mass_of = mass_of
        self._offset: Floats = np.array([sensor_offset] * n + [0.0])
        self._closed_since: Floats = np.zeros(n)
        self._sum: Floats = np.zeros(n)
        self._count: Floats = np.zeros(n)
        self._pulses: NDArray[np.int_] = np.zeros(n, dtype=int)
        while not self.box.ready:
            self.sample()

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
        names, start = self.box.settings.channels, self.box.time
        self._sum[:] = self._count[:] = 0.0  # of before the sensors were zeroed
        self.box.command(names, sine.trajectory(len(names)), 0.0, start)
        count = round((sine.end + HOLD) / PERIOD)
        for k in range(count):
            if supply is not None:
                self.bench.plant.set_supply(supply(k * PERIOD))
            self.sample()
            if k % KEPT_EVERY == 0:
                self._keep(self.box.time - start)
            if k % 1000 == 0:
                progress("sine", k / count)
        self._keep(self.box.time - start)
        series = self.record.as_series()
        return {**series, "target": sine.at(series["time"])}

    def sample(self) -> None:
        """Let a sample's time pass, and the box answer it."""
        readings = self.bench.advance(PERIOD) + self._offset
        before = self.box.valves
        valves = self.box.on_sample(self.bench.time, readings)
        self.bench.command(valves)
        self._pulses += (valves != before) & (valves != 0)
        moving = (valves != 0) | (before != 0)
        self._closed_since = np.where(moving, self.bench.time, self._closed_since)
        settled = self.bench.time - self._closed_since > SETTLING
        self._sum = np.where(settled, self._sum + self.box.gauge, 0.0)
        self._count = np.where(settled, self._count + 1.0, 0.0)

    def _keep(self, time: float) -> None:
        keep = self.record
        known = self._count > 0
        mean = self._sum / np.maximum(self._count, 1.0)
        keep.time.append(time)
        keep.estimate.append(self.box.observer.mass.copy())
        keep.truth.append(self.bench.mass)
        keep.measured.append(np.where(known, self._mass_of(mean), np.nan))
        keep.pulses.append(self._pulses.copy())
        keep.supply.append(self.box.supply)
        keep.gauge.append(self.box.gauge.copy())


def on_bottles(
    constants: Pneumatics,
    calibrations: Sequence[ChannelCalibration],
    seed: int,
    shortest: tuple[float, float] | None = None,
) -> BenchRun:
    """A run in mass control with a bottle of 0.5 L on each channel.

    Args:
        constants: of the plant.
        calibrations: one a channel.
        seed: of noise and jitter.
        shortest: pulse and pause that the box keeps [s]; None for its defaults.
    """
    n = len(calibrations)
    timing = {} if shortest is None else dict(zip(TIMING, shortest, strict=True))
    settings = BoxSettings(
        tuple(OUTLETS[:n]), (BOTTLE,) * n, (PRESSURE_LIMIT,) * n, ("mass",) * n, **timing
    )
    bench = EmbeddedBench(OUTLETS[:n], np.full(n, BOTTLE), constants, seed)
    box = PneumaticBox(settings, calibrations)
    return BenchRun(box, bench, lambda gauge: air_mass(gauge, BOTTLE))
