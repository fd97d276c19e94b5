"""A board's time: whatever clock it is of, it has to run like the computer's."""

import math

import pytest

from pneumaticbox_driver.backends.hardware.board_clock import BoardClock
from pneumaticbox_driver.backends.hardware.hardware_file import HardwareError


def checked(times):
    """Check pairs of board's time and computer's time [s]; the time of the refusal, or None."""
    clock = BoardClock()
    for time, now in times:
        try:
            assert clock.check(time, now) == time
        except HardwareError as error:
            assert "stands still, runs slow or was set back" in str(error)
            return now
    return None


def steps(rate, count=500, start=7.0):
    return [(start + 0.002 * i * rate, 1000.0 + 0.002 * i) for i in range(count)]


@pytest.mark.parametrize("rate", [1.0, 0.9995, 1.0005])
def test_any_sound_clock_is_accepted_for_an_hour(rate):
    assert checked([(rate * 0.1 * i - 5.0, 50.0 + 0.1 * i) for i in range(36_000)]) is None


def test_readings_that_take_their_time_are_no_fault_of_the_clock():
    assert checked([(t, now + 0.1 * (i % 3 == 0)) for i, (t, now) in enumerate(steps(1.0))]) is None


@pytest.mark.parametrize(("rate", "after"), [(0.0, 0.152), (1e-3, 0.152), (0.5, 0.302)])
def test_a_clock_that_stands_still_or_runs_slow_is_refused(rate, after):
    assert checked(steps(rate)) == pytest.approx(1000.0 + after, abs=0.003)


def test_a_clock_that_goes_back_is_refused():
    assert checked([*steps(1.0), (7.5, 1001.0)]) == 1001.0


def answers(times):
    """For pairs of board's time and computer's time [s], the time that is given on, or None."""
    clock = BoardClock()
    found = []
    for time, now in times:
        try:
            found.append(clock.check(time, now))
        except HardwareError:
            found.append(None)
    return found


def restarted(rate=1.0, late=0.0, gap=3.0):
    """A clock that begins at 0 again at the computer's 1001 + `gap` s, after 1 s of readings."""
    begun = 1001.0 + gap
    again = [(0.002 * i * rate, begun + 0.002 * i + late * (i % 3 == 0)) for i in range(5000)]
    return [*steps(1.0), *again]


@pytest.mark.parametrize("late", [0.0, 0.1])
@pytest.mark.parametrize("gap", [3.0, 3600.0])
def test_a_clock_that_begins_anew_is_taken_after_half_a_second_and_counts_on(late, gap):
    times = restarted(late=late, gap=gap)
    found = answers(times)[500:]
    refused = found.index(next(time for time in found if time is not None))
    assert 0.002 * refused == pytest.approx(0.5, abs=0.005)
    assert None not in found[refused:]
    # 7 s at the computer's 1000 s, before as after the restart
    computers = [now - late * (i % 3 == 0) for i, (_, now) in enumerate(times[500:])]
    expected = [now - 993.0 for now in computers[refused:]]
    assert found[refused:] == pytest.approx(expected, abs=0.002)


@pytest.mark.parametrize("rate", [0.0, 0.5])
def test_a_clock_that_begins_anew_and_does_not_keep_step_stays_refused(rate):
    assert set(answers(restarted(rate))[500:]) == {None}


def test_a_clock_that_begins_anew_again_and_again_stays_refused():
    again = [(0.002 * (i % 200), 1004.0 + 0.002 * i) for i in range(5000)]
    assert set(answers([*steps(1.0), *again])[500:]) == {None}


def test_readings_that_stay_late_are_refused_for_good_as_no_clock_was_set_back():
    late = [(t + 1.0, now + 1.2) for t, now in steps(1.0, count=5000)]
    assert set(answers([*steps(1.0), *late])[500:]) == {None}


@pytest.mark.parametrize("time", [math.nan, math.inf, None, "1", 1j])
def test_what_is_no_time_is_refused(time):
    with pytest.raises(HardwareError, match="time must be a finite number"):
        BoardClock().check(time, 1.0)
