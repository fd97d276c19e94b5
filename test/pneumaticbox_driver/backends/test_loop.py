"""The periodic loop: absolute deadlines, missed ticks dropped and counted."""

import time
from threading import Event

import pytest

from pneumaticbox_driver.backends.loop import DeadlineLoop


def run(period, steps, work):
    loop, stop, starts = DeadlineLoop(period), Event(), []

    def step():
        starts.append(time.monotonic())
        work(len(starts))
        if len(starts) == steps:
            stop.set()

    loop.run(step, stop)
    return loop, starts


def test_work_of_changing_length_does_not_move_the_deadlines():
    loop, starts = run(0.02, 15, lambda n: time.sleep(0.008 * (n % 2)))
    expected = (loop.ticks + loop.missed - 1) * loop.period
    assert starts[-1] - starts[0] == pytest.approx(expected, abs=0.018)


def test_a_step_that_takes_too_long_drops_ticks_and_counts_them():
    loop, _ = run(0.02, 5, lambda n: time.sleep(0.07 if n == 2 else 0.0))
    assert loop.ticks == 5
    assert loop.missed >= 3


def test_a_set_stop_means_no_step():
    loop, stop = DeadlineLoop(0.01), Event()
    stop.set()
    loop.run(lambda: pytest.fail("stepped"), stop)
    assert loop.ticks == 0


def test_a_period_of_zero_is_refused():
    with pytest.raises(ValueError, match="period must be above 0 s, got 0"):
        DeadlineLoop(0)
