"""The driver's control step of 8 channels, and the lateness of its loop at 500 Hz.

The lateness is compared with that of an empty loop in the same run, in turns, since what is left
of it is the machine's. Both run at real-time priority where the system grants it, as on the box of
the thesis (the node's parameter real_time_priority).
"""

from __future__ import annotations

import gc
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from bench.row import at_most, stated
from pneumaticbox_driver.backends.embedded import EmbeddedRig
from pneumaticbox_driver.backends.loop import DeadlineLoop, set_priority
from pneumaticbox_driver.box.box import PneumaticBox
from pneumaticbox_driver.box.commands import TrajectoryPoint
from pneumaticbox_driver.calibration.file import load_calibration
from pneumaticbox_driver.settings import BoxSettings

NAMES = tuple("abcdefgh")
VOLUME = 1e-4  # of the bottles [m3]
PERIOD = 0.002  # [s]
STEPS = 10_000  # of the control step alone
PAUSED_STEPS, PAUSE = 2_000, 0.0015  # of the same after a sleep, as the node has it [s]
ROUNDS, ROUND = 20, 0.75  # [s] of wall time each; short, so that both meet the same neighbours
PRIORITY = 20
STEP_TARGET = 150.0  # [us] CPU
LATENESS_TARGET, EXCESS_TARGET = 1.0, 0.3  # [ms], and above an empty loop


def eight_channels() -> tuple[PneumaticBox, EmbeddedRig]:
    """A box on bottles that follows a sine of air mass on every channel, past its start."""
    n = len(NAMES)
    settings = BoxSettings(NAMES, (VOLUME,) * n, (1.5e5,) * n, ("mass",) * n)
    box, bench = (
        PneumaticBox(settings, load_calibration(None, n)),
        EmbeddedRig(NAMES, [VOLUME] * n),
    )
    while not box.zeroing.ready:
        bench.command(box.on_sample(bench.time, bench.advance(PERIOD)))
    times = np.arange(0.1, 60.0, 0.1)
    masses = 3e-5 - 2e-5 * np.cos(times[:, None] + np.arange(n))
    points = [TrajectoryPoint(t, row) for t, row in zip(times, masses, strict=True)]
    box.command(NAMES, points, 0.0, box.time)
    return box, bench


def control_steps(count: int, pause: float = 0.0) -> tuple[list[float], list[float]]:
    """CPU times of the control step and of the simulated bottles [s], each pair after a sleep of
    `pause` [s].
    """
    box, bench = eight_channels()
    times, simulated = [], []
    for _ in range(count):
        if pause:
            time.sleep(pause)
        begin = time.thread_time_ns()
        pressures = bench.advance(PERIOD)
        start = time.thread_time_ns()
        valves = box.on_sample(bench.time, pressures)
        times.append(1e-9 * (time.thread_time_ns() - start))
        simulated.append(1e-9 * (start - begin))
        bench.command(valves)
    return times, simulated


@contextmanager
def undisturbed() -> Iterator[None]:
    """High priority, and no garbage collection inside the loop, as in the node."""
    gc.collect()
    gc.freeze()
    gc.disable()
    set_priority(PRIORITY)
    try:
        yield
    finally:
        set_priority(0)
        gc.enable()
        gc.unfreeze()


def lateness(step: Callable[[], None]) -> list[float]:
    """Lateness of the steps of one round [s]."""
    record: list[float] = []
    stop = threading.Event()
    end = time.monotonic() + ROUND

    def timed() -> None:
        step()
        if time.monotonic() > end:
            stop.set()

    with undisturbed():
        DeadlineLoop(PERIOD, record).run(timed, stop)
    return record


def run() -> list[dict[str, Any]]:
    """Control step and lateness."""
    steps, _ = control_steps(STEPS)
    paused, simulated = control_steps(PAUSED_STEPS, PAUSE)
    box, bench = eight_channels()

    def step() -> None:
        bench.command(box.on_sample(bench.time, bench.advance(PERIOD)))

    rounds = [(lateness(lambda: None), lateness(step)) for _ in range(ROUNDS)]
    empty, full = (1e3 * late(np.concatenate(records)) for records in zip(*rounds, strict=True))
    return [
        at_most("driver's control step, 8 channels: median", micro(steps, 50), "us", STEP_TARGET),
        stated("driver's control step, 8 channels: p99", micro(steps, 99), "us"),
        stated("driver's control step after a sleep: median", micro(paused, 50), "us"),
        stated("simulated bottles beside it, after a sleep: median", micro(simulated, 50), "us"),
        stated("empty loop at 500 Hz: p99 lateness", empty, "ms"),
        at_most("driver at 500 Hz: p99 lateness", full, "ms", LATENESS_TARGET),
        at_most(
            "driver at 500 Hz: p99 lateness above an empty loop",
            full - empty,
            "ms",
            EXCESS_TARGET,
        ),
    ]


def late(record: ArrayLike) -> float:
    """99th percentile [s]."""
    return float(np.percentile(record, 99))


def micro(times: Sequence[float], percentile: float) -> float:
    """Percentile in microseconds of times in seconds."""
    return 1e6 * float(np.percentile(times, percentile))
