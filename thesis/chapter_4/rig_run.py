"""A run of the box on the simulated rig that follows a sine of air mass, and its figures: drift of
the estimate, tracking error, number of pulses.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pneumaticbox_driver.backends.embedded import EmbeddedRig
from pneumaticbox_driver.box.box import PneumaticBox
from pneumaticbox_driver.box.commands import TrajectoryPoint
from pneumaticbox_driver.observer.coefficients import ChannelCalibration
from pneumaticbox_driver.settings import BoxSettings
from softhand_model.gas import air_mass
from softhand_model.pneumatics import Pneumatics
from thesis.chapter_4 import SEED
from thesis.chapter_4.boxes import BOTTLE, OUTLETS, PERIOD, SUPPLIES
from thesis.frame import Array, Progress, Results, option

KNOT = 0.05  # between the points of a command [s]
PRESSURE_LIMIT = 2e5  # gauge: within the sensors' range [Pa]
SETTLING = 0.1  # after a valve was closed, before its channel's pressure is taken [s]
KEPT_EVERY = 10  # samples
HOLD = 1.0  # after a sine, so that the last pulse is over and the pressure known [s]
TIMING = ("shortest_pulse", "shortest_pause")
Supply = Callable[[float], float]  # gauge pressure of the regulator [Pa] at a time [s]
MassOf = Callable[[Array], Array]  # air above the fill at rest [kg] at gauge pressures [Pa]


@dataclass(frozen=True)
class Sine:
    """Target of air mass: a step from rest, then `mean - amplitude cos`, then its last value.

    With the defaults the box needs about the 122 pulses of Fig. 4.9, on a bottle at about the
    working pressure of a finger.

    >>> (1e6 * Sine().at(np.array([0.0, 8.0, 18.0]))).round(3).tolist()  # mg
    [130.0, 130.0, 170.0]
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

    def at(self, time: Array) -> Array:
        """Targets at times counted from the step at rest [s], in the times' shape [kg]."""
        phase = 2 * np.pi * (np.clip(time, self.fill, self.end) - self.fill) / self.period
        return np.asarray(self.mean - self.amplitude * np.cos(phase))

    def trajectory(self, channels: int) -> list[TrajectoryPoint]:
        """The command for all channels, a point every 50 ms."""
        times = np.arange(round(self.end / KNOT) + 1) * KNOT
        return [
            TrajectoryPoint(float(time), [float(mass)] * channels)
            for time, mass in zip(times, self.at(times), strict=True)
        ]


@dataclass(frozen=True)
class SineOnBottles(Sine):
    """The sine, and the box that follows it on a bottle of 0.5 L each."""

    seed: int = option(0, SEED)
    points: int = option(100, "calibration pulses per channel, both directions together [-]")
    channels: int = option(4, "outlets of the box [-]")
    supplies: tuple[float, ...] = option(SUPPLIES, "supplies of the calibration [Pa gauge]")


SMALL_SINE: dict[str, Any]
SMALL_SINE = {"duration": 2.0, "fill": 3.0, "period": 2.0, "mean": 50e-6, "points": 24}


@dataclass
class Record:
    """Samples of a run, oldest first; per channel (n,) each."""

    time: list[float] = field(default_factory=list)
    estimate: list[Array] = field(default_factory=list)
    truth: list[Array] = field(default_factory=list)
    measured: list[Array] = field(default_factory=list)
    pulses: list[NDArray[np.int_]] = field(default_factory=list)
    supply: list[float] = field(default_factory=list)
    gauge: list[Array] = field(default_factory=list)


class RigRun:
    """The box on the simulated rig, started and tared at rest.

    `measured` is the thesis's ground truth: the mass by the sensors between pulses, NaN while a
    valve is open or has just closed. `truth` is the mass that the plant has gained, without sensor
    errors.

    Args:
        box: the driver's.
        rig: the plant's.
        mass_of: mass by the pressures, on bottles `dp V/(R T)`.
        sensor_offset: added to the channels' sensors besides their own errors [Pa].
    """

    def __init__(
        self, box: PneumaticBox, rig: EmbeddedRig, mass_of: MassOf, sensor_offset: float = 0.0
    ) -> None:
        n = len(box.settings.channels)
        self.box, self.rig, self.record = box, rig, Record()
        self._mass_of = mass_of
        self._offset: Array = np.array([sensor_offset] * n + [0.0])
        self._closed_since, self._sum, self._count = np.zeros(n), np.zeros(n), np.zeros(n)
        self._pulses: NDArray[np.int_] = np.zeros(n, dtype=int)
        while not self.box.zeroing.ready:
            self.sample()

    def follow(self, sine: Sine, progress: Progress, supply: Supply | None = None) -> Results:
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
                self.rig.plant.set_supply(supply(k * PERIOD))
            self.sample()
            if k % KEPT_EVERY == 0:
                self._keep(self.box.time - start)
            if k % 1000 == 0:
                progress("sine", k / count)
        self._keep(self.box.time - start)
        series = {name: np.array(v, dtype=float) for name, v in vars(self.record).items()}
        return {**series, "target": sine.at(series["time"])}

    def sample(self) -> None:
        """Advance by one sample, and let the box answer it."""
        readings = self.rig.advance(PERIOD) + self._offset
        before = self.box.valves
        valves = self.box.on_sample(self.rig.time, readings)
        self.rig.command(valves)
        self._pulses += (valves != before) & (valves != 0)
        moving = (valves != 0) | (before != 0)
        self._closed_since = np.where(moving, self.rig.time, self._closed_since)
        settled = self.rig.time - self._closed_since > SETTLING
        self._sum = np.where(settled, self._sum + self.box.pressures, 0.0)
        self._count = np.where(settled, self._count + 1.0, 0.0)

    def _keep(self, time: float) -> None:
        keep = self.record
        mean = self._sum / np.maximum(self._count, 1.0)
        keep.time.append(time)
        keep.estimate.append(self.box.observer.mass.copy())
        keep.truth.append(self.rig.mass)
        keep.measured.append(np.where(self._count > 0, self._mass_of(mean), np.nan))
        keep.pulses.append(self._pulses.copy())
        keep.supply.append(self.box.supply_abs)
        keep.gauge.append(self.box.pressures.copy())


def on_bottles(
    constants: Pneumatics,
    calibrations: Sequence[ChannelCalibration],
    seed: int,
    shortest: tuple[float, float] | None = None,
) -> RigRun:
    """A run in mass control with a bottle of 0.5 L on each channel.

    Args:
        constants: of the plant.
        calibrations: one per channel.
        seed: of noise and jitter.
        shortest: pulse and pause that the box keeps [s]; None for its defaults.
    """
    n = len(calibrations)
    timing = {} if shortest is None else dict(zip(TIMING, shortest, strict=True))
    settings = BoxSettings(
        tuple(OUTLETS[:n]), (BOTTLE,) * n, (PRESSURE_LIMIT,) * n, ("mass",) * n, **timing
    )
    rig = EmbeddedRig(OUTLETS[:n], np.full(n, BOTTLE), constants, seed)
    return RigRun(PneumaticBox(settings, calibrations), rig, lambda p: air_mass(p, BOTTLE))


def under(prefix: str, run: Results) -> Results:
    """A run with a prefix before its names, so that two runs go into one file.

    >>> under("own", {"time": np.zeros(1)})
    {'own_time': array([0.])}
    """
    return {f"{prefix}_{name}": values for name, values in run.items()}


def of(prefix: str, results: Results) -> Results:
    """The run that `under` has given this prefix."""
    head = f"{prefix}_"
    return {name[len(head) :]: v for name, v in results.items() if name.startswith(head)}


def drift(run: Results, truth: str = "truth") -> Array:
    """Contained less estimated mass (samples, channels) [kg]; NaN unless the channel is still.

    Args:
        run: a record of `RigRun.follow`.
        truth: "truth" of the plant, or "measured" as in the thesis.
    """
    return np.where(np.isfinite(run["measured"]), run[truth] - run["estimate"], np.nan)


def final_drift(run: Results, truth: str = "truth") -> Array:
    """Drift (channels,) [kg] at the last sample at which the channel is still."""
    return np.array([column[np.isfinite(column)][-1] for column in drift(run, truth).T])


def in_sine(run: Results, sine: Sine) -> NDArray[np.bool_]:
    """Marks the samples of the sine itself, without fill and hold (samples,)."""
    return (run["time"] >= sine.fill) & (run["time"] <= sine.end)


def tracking_error(run: Results, sine: Sine, followed: str = "truth") -> Array:
    """Actual minus target mass over the sine (samples of it, channels) [kg]; for the "estimate",
    the controller's error without drift.
    """
    here = in_sine(run, sine)
    return np.asarray(run[followed][here] - run["target"][here, None])


def pulses_in_sine(run: Results, sine: Sine) -> Array:
    """Pulses per channel that the sine took (channels,)."""
    counts = run["pulses"][in_sine(run, sine)]
    return np.asarray(counts[-1] - counts[0])
