"""Error of valve events scheduled ahead, simulated and by the wall clock (section 4.3).

The thesis: sub-millisecond accurate by scheduling ahead.
"""

import threading
import time
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from pneumaticbox_driver.backends.embedded import EmbeddedRig
from pneumaticbox_driver.backends.loop import DeadlineLoop, set_priority
from pneumaticbox_driver.box.box import PneumaticBox
from pneumaticbox_driver.box.commands import TrajectoryPoint
from pneumaticbox_driver.calibration.file import load_calibration
from pneumaticbox_driver.settings import BoxSettings
from thesis.chapter_4 import FULL, NOTE, OTHER, SEED, THESIS_LINE, rms
from thesis.chapter_4.boxes import BOTTLE, OUTLETS, PERIOD, box_of
from thesis.chapter_4.rig_run import PRESSURE_LIMIT
from thesis.frame import Array, Figure, Job, Report, Results, number, option

PRIORITY = 20  # of the loop by the wall clock
LEAD = 0.2  # from the command to the first event [s]
SPACING = (0.07, 0.14)  # between events: above what the valves can follow [s]
SHOWN = 3.0  # largest error in the picture, which holds those beyond it too [ms]
CLOCKS = {"simulated": "simulated time", "wall": "wall clock"}
SMALL = {"events": 30, "wall_events": 4, "channels": 2}


@dataclass(frozen=True)
class Parameters:
    """Options of the experiment."""

    seed: int = option(0, SEED)
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
        n = channels
        settings = BoxSettings(self.names, (BOTTLE,) * n, (PRESSURE_LIMIT,) * n, ("time",) * n)
        self.box = PneumaticBox(settings, load_calibration(None, channels))
        self.rig = EmbeddedRig(self.names, np.full(channels, BOTTLE), box_of(0), seed)
        random = np.random.default_rng(seed)
        self.planned = np.cumsum(random.uniform(*SPACING, (events, channels)), axis=0)
        self.acted: Array = np.full((events, channels), np.nan)
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
        readings = self.rig.advance(PERIOD)
        valves = self.box.on_sample(clock(), readings)
        self.rig.command(valves)
        now = clock()
        for channel in np.flatnonzero(valves != before).tolist():
            if self._next[channel] < len(self.acted):
                self.acted[self._next[channel], channel] = now
                self._next[channel] += 1

    @property
    def done(self) -> bool:
        """Whether all events have acted."""
        return bool((self._next >= len(self.acted)).all())


def run(given: Parameters, job: Job) -> Results:
    """Errors of all events [s]: samples exactly every 2 ms, and by the wall clock."""
    job.progress("simulated time", 0.0)
    simulated_box = ScheduledBox(given.channels, given.events, given.seed)
    simulated = errors_of(simulated_box, lambda: simulated_box.rig.time, _without_waiting)
    job.progress("wall clock", 0.5)
    real, began = ScheduledBox(given.channels, given.wall_events, given.seed), time.monotonic()
    wall = errors_of(real, lambda: time.monotonic() - began, _every_period)
    return {"simulated": simulated, "wall": wall}


Step = Callable[[], None]


def errors_of(
    box: ScheduledBox, clock: Callable[[], float], loop: Callable[[Step, threading.Event], None]
) -> Array:
    """Errors of the events [s] when a loop samples the box, stamped by a clock [s]."""
    stop, scheduled = threading.Event(), threading.Event()

    def step() -> None:
        box.sample(clock)
        if box.box.zeroing.ready and not scheduled.is_set():
            scheduled.set()
            box.schedule(box.box.time + LEAD)
        if box.done:
            stop.set()

    loop(step, stop)
    return np.asarray((box.acted - box.planned).ravel())


def _without_waiting(step: Step, stop: threading.Event) -> None:
    while not stop.is_set():
        step()


def _every_period(step: Step, stop: threading.Event) -> None:
    """Wait for each period, at real-time priority where the system grants it, like the driver's
    loop.
    """
    set_priority(PRIORITY)
    try:
        DeadlineLoop(PERIOD).run(step, stop)
    finally:
        set_priority(0)


def report(results: Results, given: Parameters) -> Report:
    """Errors in samples of 2 ms and in milliseconds."""
    findings = []
    for name, title in CLOCKS.items():
        size = np.abs(results[name])
        findings += [
            number(f"{title}: RMS error", float(rms(size)) / PERIOD, "samples"),
            number(f"{title}: 99 % of the events within", percentile(size) / PERIOD, "samples"),
            number(f"{title}: 99 % of the events within", 1e3 * percentile(size), "ms", "< 1"),
            number(f"{title}: largest error", float(size.max()) / PERIOD, "samples"),
        ]
    worst = float(np.abs(results["simulated"]).max()) / PERIOD
    p99 = 1e3 * percentile(np.abs(results["wall"]))
    conclusion = (
        f"Events act within {worst:.2f} samples of 2 ms in simulated time; by the wall clock 99 % "
        f"within {p99:.2f} ms (thesis: sub-millisecond)."
    )
    return Report(findings, conclusion)


def percentile(errors: Array) -> float:
    """The error that 99 % of the events stay below [s]."""
    return float(np.percentile(errors, 99))


def draw(figure: Figure, results: Results, report: Report) -> None:
    """Histograms of the errors, in simulated time and by the wall clock."""
    axes = figure.subplots(1, 2, sharey=True)
    bins = np.linspace(-SHOWN, SHOWN, 81)
    for panel, (name, title), colour in zip(axes, CLOCKS.items(), (FULL, OTHER), strict=True):
        errors = 1e3 * results[name]
        share = np.full(len(errors), 100.0 / len(errors))
        panel.hist(np.clip(errors, -SHOWN, SHOWN), bins, weights=share, color=colour)
        for limit in (-1.0, 1.0):
            panel.axvline(limit, color=THESIS_LINE, ls="--", lw=1.0)
        panel.annotate(
            "thesis: < 1 ms", (1.0, 0.97), (3, -8), xycoords=("data", "axes fraction"), **NOTE
        )
        panel.set(title=f"{title}, {len(errors)} events", xlabel="acted less scheduled [ms]")
    axes[0].set_ylabel("events [%]")
