"""A step of the wall clock does not reach the box."""

import numpy as np
import pytest

from pneumaticbox_driver.backends.embedded import EmbeddedBoard, EmbeddedRig
from pneumaticbox_driver.backends.loop import SteadyClock


class Clocks:
    """A monotonic clock, and a wall clock that can be set."""

    def __init__(self):
        self.monotonic, self.offset = 100.0, 1.7e9

    def steady(self):
        return SteadyClock(lambda: self.monotonic, lambda: self.monotonic + self.offset)


@pytest.mark.parametrize("step", [-3600.0, -0.5, 0.7, 86400.0])
def test_it_goes_on_evenly_when_the_wall_clock_is_set(step):
    clocks = Clocks()
    clock = clocks.steady()
    before = clock.now()
    clocks.monotonic += 0.002
    clocks.offset += step
    assert clock.now() - before == pytest.approx(0.002, abs=1e-6)


@pytest.mark.parametrize("step", [0.0, -3600.0, 86400.0])
def test_a_stamp_of_the_present_wall_clock_keeps_its_distance_from_now(step):
    clocks = Clocks()
    clock = clocks.steady()
    clocks.offset += step
    wall = clocks.monotonic + clocks.offset
    assert clock.of_stamp(wall + 2.5) - clock.now() == pytest.approx(2.5, abs=1e-6)


def test_no_stamp_stays_no_stamp_and_the_past_stays_past():
    clock = Clocks().steady()
    assert clock.of_stamp(0.0) == 0.0
    assert 0.0 < clock.of_stamp(1e9) < clock.now()


def test_the_simulated_box_runs_by_the_monotonic_clock():
    clocks = Clocks()
    board = EmbeddedBoard(EmbeddedRig(["a"], [1e-4]), lambda: clocks.monotonic)
    board.command(np.array([1], dtype=np.int8))
    for _ in range(100):
        clocks.monotonic += 0.002
        pressures = board.read()
    assert board.rig.time == pytest.approx(0.2)
    assert board.time == clocks.monotonic
    assert pressures[0] > 104e3  # from 101.3 kPa


def test_the_simulated_box_takes_whole_milliseconds_and_loses_none():
    clocks = Clocks()
    board = EmbeddedBoard(EmbeddedRig(["a"], [1e-4]), lambda: clocks.monotonic)
    for passed, run in ((0.0027, 0.002), (0.0002, 0.002), (0.0002, 0.003), (0.0059, 0.009)):
        clocks.monotonic += passed
        board.read()
        assert board.rig.time == pytest.approx(run)
        assert board.time == pytest.approx(100.0 + run)
