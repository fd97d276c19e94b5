"""Calibration run: its plan, its valves for sensor samples, and its session in the box."""

import math
from collections.abc import Generator, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike

from pneumaticbox_driver.arrays import Floats, Valves
from pneumaticbox_driver.calibration.recording import (
    PULSE_SETTLING,
    PulseDurations,
    PulseRanges,
    PulseRecorder,
    Sample,
    Step,
    average,
    measure_leaks,
)
from pneumaticbox_driver.calibration.regression import fit_channel
from pneumaticbox_driver.observer.coefficients import ChannelCalibration, Leak
from pneumaticbox_driver.safety import PressureGuard
from softhand_model.gas import AMBIENT_PRESSURE

LEAST_CHANGE = 10e3  # between two supply pressures, to separate the terms [Pa]
NEXT_SUPPLY = "turn the supply regulator to another pressure, then call pneumaticbox/calibrate_next"
VENT_WINDOW = 0.5  # of averages that are compared while the outlets are open [s]
VENT_STILL = 30.0  # fall of the pressure below which a channel is empty [Pa]
EMPTYING_LIMIT = 60.0  # a bottle of 0.5 L is empty after a tenth of this time [s]
LEAK_SETTLING = 3.0  # after filling, until the gas has the temperature of the walls [s]
LEAST_LIFT = 1e3  # rise of the pressure that inflating pulses must cause [Pa]


@dataclass(frozen=True)
class CalibrationPlan:
    """Plan of a calibration.

    points: number of pulses per channel, in both directions and at all supply pressures together.
    supplies: number of supply pressures; the run waits until the user has set the next one. ranges:
    of the pulses. settling, averaging [s]: after each pulse, how long the pressure settles and is
    then averaged. leak_test [s]: duration of the leak test at the end, 0 for none.

    Raises:
        ValueError: names the entry, what was expected and what was found.
    """

    points: int = 400
    supplies: int = 2
    ranges: PulseRanges = field(default_factory=PulseRanges)
    settling: float = PULSE_SETTLING
    averaging: float = 0.8  # long, as there are few pulses
    leak_test: float = 30.0

    def __post_init__(self) -> None:
        if self.supplies < 1:
            raise ValueError(f"supplies must be at least 1, got {self.supplies}")
        least = 12 * self.supplies
        if self.points < least:
            raise ValueError(
                f"points must be at least {least} for {self.supplies} supply pressures, "
                f"got {self.points}"
            )
        for name in ("settling", "averaging"):
            value = getattr(self, name)
            if not (math.isfinite(value) and value > 0):
                raise ValueError(f"{name} must be above 0 s, got {value}")
        if not (math.isfinite(self.leak_test) and self.leak_test >= 0):
            raise ValueError(f"leak_test must be 0 s or above, got {self.leak_test}")

    @property
    def cycles(self) -> int:
        """Number of inflations of each channel at each supply pressure, and of deflations."""
        return math.ceil(self.points / (2 * self.supplies))


class CalibrationRun:
    """Carries out a `CalibrationPlan` on all channels at once, sample by sample.

    It vents all channels, zeroes their sensors at ambient pressure, and carries out Algorithm 1 at
    the present supply pressure. Then it waits with closed valves for another supply pressure and
    `next`, until the plan is done; after the leak test the coefficients are fitted.

    `state` is "running", "waiting", "done" or "failed", `progress` is 0 to 1 over the whole plan,
    and `message` a sentence on what it does, waits for, or why it failed.

    Args:
        channels: names of the channels.
        volumes: fixed volumes on the channels (n,) [m3].
        plan: plan of the calibration; None for the defaults.
        seed: seed of the durations.
        aside: whether to fit in a thread: the fit takes seconds, too long for a control step.

    Raises:
        ValueError: the volumes are not one per channel, or not above 0.
    """

    def __init__(
        self,
        channels: Sequence[str],
        volumes: ArrayLike,
        plan: CalibrationPlan | None = None,
        seed: int = 0,
        aside: bool = False,
    ) -> None:
        n = len(channels)
        self.channels = tuple(channels)
        self.volumes = np.asarray(volumes, dtype=float)
        if self.volumes.shape != (n,) or not (self.volumes > 0).all():
            got = self.volumes.tolist()
            raise ValueError(f"volumes must be {n} above 0 m3, one per channel, got {got}")
        self.plan = CalibrationPlan() if plan is None else plan
        self.state = "running"
        self.progress = 0.0
        self.message = "venting the channels to zero their sensors"
        self._seed = seed
        self._aside = aside
        self._closed: Valves = np.zeros(n, dtype=np.int8)
        self._supply_abs = AMBIENT_PRESSURE  # of the last sample [Pa]
        self._supplies: list[float] = []  # of the levels so far [Pa]
        self._result: list[ChannelCalibration] = []
        self._steps = self._play()
        self._valves = next(self._steps)

    @property
    def under_way(self) -> bool:
        """Whether the run has not ended yet."""
        return self.state in ("running", "waiting")

    @property
    def result(self) -> list[ChannelCalibration]:
        """The calibrations, one per channel; raises ValueError unless the run is done."""
        if self.state != "done":
            raise ValueError(f"the calibration has no result: {self.state}, {self.message}")
        return self._result

    def on_sample(self, sample: Sample) -> Valves:
        """Return the valves (n,) for a sensor sample; closed unless running.

        The run fails for a sample that is not a finite number.
        """
        self._supply_abs = sample.supply_abs
        if self.state != "running":
            return self._closed
        if not np.isfinite(sample.pressures_abs.sum() + sample.supply_abs):
            self.abort("a sensor sample was not a number")
            return self._closed
        try:
            self._valves = self._steps.send(sample)
        except StopIteration:
            self.state, self.progress = "done", 1.0
            self.message = f"calibrated channels {', '.join(self.channels)}"
            return self._closed
        except ValueError as error:
            self.abort(str(error))
            return self._closed
        return self._closed if self.state == "waiting" else self._valves

    def next(self) -> str:
        """Continue at the present supply pressure.

        Returns:
            A sentence on what is done now.

        Raises:
            ValueError: the run does not wait, or has already been at this supply pressure.
        """
        if self.state != "waiting":
            raise ValueError(f"the calibration does not wait: {self.state}, {self.message}")
        supply = self._supply_abs - AMBIENT_PRESSURE
        near = [old for old in self._supplies if abs(old - supply) < LEAST_CHANGE]
        if near:
            raise ValueError(
                f"the supply is at {supply / 1e3:.0f} kPa, where pulses have been recorded: "
                f"turn it by {LEAST_CHANGE / 1e3:.0f} kPa or more, then call again"
            )
        self.state = "running"
        self.message = f"continues at a supply of {supply / 1e3:.0f} kPa"
        return self.message

    def abort(self, reason: str) -> None:
        """End the run without a result; does nothing when the run has ended."""
        if self.under_way:
            self.state, self.message = "failed", reason

    # the steps of a run

    def _play(self) -> Step:
        recorder = PulseRecorder(
            len(self.channels),
            self.volumes,
            self.plan.settling,
            self.plan.averaging,
            1.5 * self.plan.ranges.high_pressure,
        )
        for level in range(self.plan.supplies):
            yield from self._level(level, recorder)
            if level + 1 < self.plan.supplies:
                yield from self._wait(level)
        leaks = yield from self._leaks(recorder)
        self._result = yield from self._fit(recorder, leaks)

    def _level(self, level: int, recorder: PulseRecorder) -> Step:
        yield from self._vent()
        yield from recorder.zero()
        self._supplies.append(self._supply_abs - AMBIENT_PRESSURE)
        durations = PulseDurations(self.plan.ranges, len(self.channels), 1000 * self._seed + level)
        lifted, cycles = np.zeros(len(self.channels)), self.plan.cycles
        for cycle in range(cycles):
            self.progress = 0.95 * (level + cycle / cycles) / self.plan.supplies
            self.message = (
                f"supply pressure {level + 1} of {self.plan.supplies} "
                f"({self._supplies[-1] / 1e3:.0f} kPa), pulse {cycle + 1} of {cycles}"
            )
            yield from recorder.cycle(durations)
            lifted = np.maximum(lifted, recorder.pressures)
            if cycle == cycles // 2:
                self._check_lift(lifted)

    def _check_lift(self, lifted: Floats) -> None:
        """Raise ValueError for a channel whose pressure did not rise, for example by a loose tube,
        a stuck valve or a missing supply.
        """
        for name, pressure in zip(self.channels, lifted.tolist(), strict=True):
            if pressure < LEAST_LIFT:
                raise ValueError(
                    f"channel {name}: the pressure does not rise with the inlet open: check the "
                    "supply, the tube and the bottle"
                )

    def _vent(self) -> Step:
        """Open all outlets until the pressures no longer fall."""
        outlets: Valves = np.full(len(self.channels), -1, dtype=np.int8)
        sample = yield outlets
        start, before = sample.time, None
        while sample.time - start < EMPTYING_LIMIT:
            since, total, count = sample.time, np.zeros(len(outlets)), 0
            while sample.time - since < VENT_WINDOW:
                sample = yield outlets
                total, count = total + sample.pressures_abs, count + 1
            mean = total / count
            if before is not None and (before - mean < VENT_STILL).all():
                break
            before = mean
        yield from average(len(outlets), self.plan.settling)

    def _wait(self, level: int) -> Step:
        self.state = "waiting"
        self.message = f"supply pressure {level + 1} of {self.plan.supplies} is done: {NEXT_SUPPLY}"
        yield self._closed

    def _leaks(self, recorder: PulseRecorder) -> Generator[Valves, Sample, list[Leak]]:
        if self.plan.leak_test == 0:
            return [Leak()] * len(self.channels)
        self.progress = 0.95
        self.message = f"leak test, {self.plan.leak_test:.0f} s"
        yield from self._fill(recorder)
        yield from average(len(self.channels), LEAK_SETTLING)
        return (yield from measure_leaks(self.volumes, recorder.offsets, self.plan.leak_test))

    def _fill(self, recorder: PulseRecorder) -> Step:
        """Inflate every channel to the high pressure of the pulses."""
        target = self.plan.ranges.high_pressure + AMBIENT_PRESSURE
        sample = yield self._closed
        start = sample.time
        while sample.time - start < EMPTYING_LIMIT:
            wanted = sample.pressures_abs - recorder.offsets < target
            if not wanted.any():
                break
            sample = yield wanted.astype(np.int8)
        yield from average(len(self.channels), self.plan.settling)

    def _fit(
        self, recorder: PulseRecorder, leaks: list[Leak]
    ) -> Generator[Valves, Sample, list[ChannelCalibration]]:
        if not self._aside:
            return self._fitted(recorder, leaks)
        self.progress = 0.99
        self.message = "fitting the coefficients"
        pool = ThreadPoolExecutor(1)
        work = pool.submit(self._fitted, recorder, leaks)
        pool.shutdown(wait=False)
        while not work.done():
            yield self._closed
        return work.result()

    def _fitted(self, recorder: PulseRecorder, leaks: list[Leak]) -> list[ChannelCalibration]:
        result = []
        each = zip(self.channels, recorder.pulses(), leaks, strict=True)
        for outlet, (name, pulses, leak) in enumerate(each, start=1):
            try:
                result.append(fit_channel(pulses, leak, outlet))
            except ValueError as error:
                raise ValueError(f"channel {name}: {error}") from error
        return result


class CalibrationSession:
    """The latest calibration of a box; `run` is None before the first one.

    Args:
        channels: names of the box's channels.
    """

    def __init__(self, channels: tuple[str, ...]) -> None:
        self._channels = channels
        self.run: CalibrationRun | None = None

    @property
    def under_way(self) -> bool:
        """Whether a calibration is commanding the valves."""
        return self.run is not None and self.run.under_way

    def start(self, run: CalibrationRun) -> str:
        """Begin a calibration of all channels; returns a sentence.

        Raises:
            ValueError: a calibration is running, or the run is for other channels.
        """
        self.refuse_under_way()
        if tuple(run.channels) != self._channels:
            expected = list(self._channels)
            raise ValueError(f"calibration: expected channels {expected}, got {list(run.channels)}")
        self.run = run
        return f"calibration has begun: {run.message}"

    def refuse_under_way(self) -> None:
        """Raise ValueError while a calibration is running, which commands the valves."""
        if self.run is not None and self.run.under_way:
            raise ValueError(f"a calibration is under way: {self.run.message}")

    def next(self) -> str:
        """Continue at another supply pressure; raises ValueError unless a run waits for it."""
        if self.run is None:
            raise ValueError("no calibration is under way: call pneumaticbox/calibrate first")
        return self.run.next()

    def answer(self, time: float, readings: Floats, guard: PressureGuard) -> Valves:
        """Valves (n,) of the calibration for a sample.

        Args:
            time: time of the sample [s].
            readings: absolute pressures as read by the sensors, supply last (n + 1,) [Pa].
            guard: the guard of the pressure limits; when it relieves a channel, the run fails.
        """
        run = self.run
        if run is None:
            return np.zeros(len(self._channels), dtype=np.int8)
        if guard.relieving.any():
            name = self._channels[int(np.argmax(guard.relieving))]
            run.abort(f"channel {name} has reached its pressure limit: raise pressure_limits")
        return run.on_sample(Sample.of(time, readings))

    def abort(self, reason: str) -> None:
        """End a running calibration without a result."""
        if self.run is not None:
            self.run.abort(reason)
