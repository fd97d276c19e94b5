"""Section 4.3: how near to its time a valve event acts that was scheduled ahead."""

import threading
import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from pneumaticbox_driver.backends.embedded import EmbeddedBench
from pneumaticbox_driver.backends.loop import DeadlineLoop, set_priority
from pneumaticbox_driver.box.box import PneumaticBox
from pneumaticbox_driver.box.commands import TrajectoryPoint
from pneumaticbox_driver.calibration.file import load_calibration
from pneumaticbox_driver.settings import BoxSettings
from thesis.chapter_4.bench_run import PRESSURE_LIMIT
from thesis.chapter_4.boxes import BOTTLE, OUTLETS, PERIOD, box_of
from thesis.chapter_4.report import (
    FULL,
    OTHER,
    THESIS_LINE,
    Floats,
    Metric,
    Progress,
    Report,
    Series,
    option,
    rms,
)

if TYPE_CHECKING:
    from matplotlib.figure import Figure

SENTENCE = "error of valve events that are scheduled ahead, in simulated time and by the wall clock"
THESIS = "section 4.3, sub-millisecond accurate by scheduling ahead"
PRIORITY = 20  # of the loop by the wall clock
LEAD = 0.2  # from the command to the first event [s]
SPACING = (0.07, 0.14)  # between events: above what the valves can follow [s]
SHOWN = 3.0  # largest error in the picture, which holds those beyond it too [ms]
CLOCKS = {"simulated": "simulated time", "wall": "wall clock"}


@dataclass(frozen=True)
class Settings:
    """Options of the experiment."""

    events: int = option(400, "events per channel in simulated time [-]")
    wall_events: int = option(60, "events per channel by the wall clock, 0.1 s each [-]")
    channels: int = option(4, "outlets of the box [-]")

    def __post_init__(self) -> None:
        if min(self.events, self.wall_events, self.channels) < 1:
            raise ValueError(f"events and channels must be at least 1, got {self}")


class ScheduledBox:
    """A box in time mode that is sent random events ahead, and notes when each one acts.

    Args:
        channels: number of outlets.
        events: per channel.
        seed: of the events.
    """

    def __init__(self, channels: int, events: int, seed: int) -> None:
        self.names = tuple(OUTLETS[:channels])
        per_channel = [(value,) * channels for value in (BOTTLE, PRESSURE_LIMIT)]
        settings = BoxSettings(self.names, *per_channel, ("time",) * channels)
        self.box = PneumaticBox(settings, load_calibration(None, channels))
        self.bench = EmbeddedBench(self.names, np.full(channels, BOTTLE), box_of(0), seed)
        random = np.random.default_rng(seed)
        self.planned = np.cumsum(random.uniform(*SPACING, (events, channels)), axis=0)
        self.acted: Floats = np.full((events, channels), np.nan)
        self._next = np.zeros(channels, dtype=int)

    def schedule(self, start: float) -> None:
        """Send the events of all channels, to begin at `start` [s]: inflate, closed, deflate ..."""
        self.planned = self.planned + start
        states = [1.0, 0.0, -1.0, 0.0]
        for channel, name in enumerate(self.names):
            times = self.planned[:, channel]
            points = [
                TrajectoryPoint(float(t - start), [states[k % 4]]) for k, t in enumerate(times)
            ]
            self.box.schedule_valves([name], points, start, self.box.time)

    def sample(self, clock: Callable[[], float]) -> None:
        """Answer one sample, stamped by `clock` [s], and note by it when valves are switched."""
        before = self.box.valves
        readings = self.bench.advance(PERIOD)
        valves = self.box.on_sample(clock(), readings)
        self.bench.command(valves)
        now = clock()
        for channel in np.flatnonzero(valves != before).tolist():
            if self._next[channel] < len(self.acted):
                self.acted[self._next[channel], channel] = now
                self._next[channel] += 1

    @property
    def done(self) -> bool:
        """Whether all events have acted."""
        return bool((self._next >= len(self.acted)).all())

    @property
    def errors(self) -> Floats:
        """Acted less planned times of all events [s]."""
        return np.asarray((self.acted - self.planned).ravel())


def simulate(settings: Settings, seed: int, progress: Progress) -> Series:
    """Errors of all events [s], in simulated time and by the wall clock."""
    progress("simulated time", 0.0)
    simulated = in_simulated_time(settings, seed)
    progress("wall clock", 0.5)
    return {"simulated": simulated, "wall": by_the_wall_clock(settings, seed)}


def in_simulated_time(settings: Settings, seed: int) -> Floats:
    """Errors of the events when the samples come exactly every 2 ms [s]."""
    run = ScheduledBox(settings.channels, settings.events, seed)
    while not run.box.zeroing.ready:
        run.sample(lambda: run.bench.time)
    run.schedule(run.box.time + LEAD)
    while not run.done:
        run.sample(lambda: run.bench.time)
    return run.errors


def by_the_wall_clock(settings: Settings, seed: int) -> Floats:
    """Errors of the events in a loop at 500 Hz of the wall clock, samples stamped by it [s].

    The loop runs at real-time priority where the system grants it, as the driver's can.
    """
    run = ScheduledBox(settings.channels, settings.wall_events, seed)
    began, stop = time.monotonic(), threading.Event()

    def clock() -> float:
        return time.monotonic() - began

    def step() -> None:
        run.sample(clock)
        if run.box.zeroing.ready and np.isnan(scheduled[0]):
            scheduled[0] = run.box.time + LEAD
            run.schedule(scheduled[0])
        if run.done:
            stop.set()

    scheduled = [float("nan")]
    set_priority(PRIORITY)
    try:
        DeadlineLoop(PERIOD).run(step, stop)
    finally:
        set_priority(0)
    return run.errors


def report(series: Series, settings: Settings) -> Report:
    """Errors in samples of 2 ms and in milliseconds."""
    metrics = []
    for name, title in CLOCKS.items():
        size = np.abs(series[name])
        metrics += [
            Metric(f"{title}: RMS error", float(rms(size)) / PERIOD, "samples"),
            Metric(f"{title}: 99 % of the events within", percentile(size) / PERIOD, "samples"),
            Metric(f"{title}: 99 % of the events within", 1e3 * percentile(size), "ms", "< 1"),
            Metric(f"{title}: largest error", float(size.max()) / PERIOD, "samples"),
        ]
    worst = float(np.abs(series["simulated"]).max()) / PERIOD
    p99 = 1e3 * percentile(np.abs(series["wall"]))
    verdict = (
        f"events act within {worst:.2f} samples of 2 ms in simulated time; by the wall clock 99 % "
        f"within {p99:.2f} ms (thesis: sub-millisecond)"
    )
    return Report(tuple(metrics), verdict)


def percentile(errors: Floats) -> float:
    """The error that 99 % of the events stay below [s]."""
    return float(np.percentile(errors, 99))


def draw(figure: "Figure", series: Series, result: Report) -> None:
    """Histograms of the errors, in simulated time and by the wall clock."""
    axes = figure.subplots(1, 2, sharey=True)
    bins = np.linspace(-SHOWN, SHOWN, 81)
    for panel, (name, title), colour in zip(axes, CLOCKS.items(), (FULL, OTHER), strict=True):
        errors = 1e3 * series[name]
        share = np.full(len(errors), 100.0 / len(errors))
        panel.hist(np.clip(errors, -SHOWN, SHOWN), bins, weights=share, color=colour)
        for limit in (-1.0, 1.0):
            panel.axvline(limit, color=THESIS_LINE, ls="--", lw=1.0)
        panel.annotate(
            "thesis: < 1 ms",
            (1.0, 0.97),
            (3, -8),
            xycoords=("data", "axes fraction"),
            textcoords="offset points",
            color="#555555",
        )
        panel.set(title=f"{title}, {len(errors)} events", xlabel="acted less scheduled [ms]")
    axes[0].set_ylabel("events [%]")
