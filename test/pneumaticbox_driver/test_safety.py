"""Pressure limits, silence and the latch, piece by piece."""

import numpy as np

from pneumaticbox_driver.safety import PressureGuard, SampleWatch, VentLatch

INFLATE = np.array([1, 1], dtype=np.int8)
TARGETS = np.array([9e-5, 9e-5])


def guard():
    return PressureGuard(np.array([50e3, 80e3]))


def test_below_the_limits_the_guard_changes_nothing():
    assert guard().apply(np.array([49e3, 79e3]), TARGETS, INFLATE) is INFLATE


def test_above_its_limit_a_channel_is_relieved_and_the_other_goes_on():
    keeper = guard()
    assert keeper.apply(np.array([51e3, 60e3]), TARGETS, INFLATE).tolist() == [-1, 1]
    assert keeper.apply(np.array([49e3, 60e3]), TARGETS, INFLATE).tolist() == [-1, 1]
    assert keeper.apply(np.array([48e3, 60e3]), TARGETS, INFLATE).tolist() == [0, 1]


def test_the_channel_is_not_inflated_again_to_the_same_target():
    keeper = guard()
    keeper.apply(np.array([51e3, 0]), TARGETS, INFLATE)
    keeper.apply(np.array([40e3, 0]), TARGETS, INFLATE)
    assert keeper.apply(np.array([20e3, 0]), TARGETS, INFLATE).tolist() == [0, 1]
    lower = np.array([3e-5, 9e-5])
    assert keeper.apply(np.array([20e3, 0]), lower, INFLATE).tolist() == [1, 1]


def test_a_new_command_may_inflate_again():
    keeper = guard()
    keeper.apply(np.array([51e3, 0]), TARGETS, INFLATE)
    keeper.apply(np.array([40e3, 0]), TARGETS, INFLATE)
    keeper.unblock((0,))
    assert keeper.apply(np.array([20e3, 0]), TARGETS, INFLATE).tolist() == [1, 1]


def test_after_a_reset_the_target_that_led_over_the_limit_may_be_tried_again():
    keeper = guard()
    keeper.apply(np.array([51e3, 0]), TARGETS, INFLATE)
    keeper.restart()
    keeper.unblock((0,))
    assert keeper.apply(np.array([20e3, 0]), TARGETS, INFLATE).tolist() == [1, 1]
    assert keeper.apply(np.array([51e3, 0]), TARGETS, INFLATE).tolist() == [-1, 1]


def test_a_pressure_far_above_its_limit_means_that_relief_has_failed():
    assert guard().burst(np.array([59e3, 95e3])) is None
    assert guard().burst(np.array([59e3, 97e3])) == 1


def test_the_sensors_are_watched_from_the_first_sample_on():
    watch = SampleWatch()
    assert watch.silence(100.0, 100.0, simulated=False) is None
    assert not watch.started


def test_silence_of_250_ms_of_node_time_is_a_fault():
    watch = SampleWatch()
    watch.note(10.0, 50.0)
    assert watch.silence(10.25, 50.25, simulated=False) is None
    assert watch.silence(10.26, 50.26, simulated=False) == "no sensor sample for 250 ms"


def test_the_first_tick_of_simulated_time_is_no_silence():
    watch = SampleWatch()
    watch.note(0.0, 50.0)
    assert watch.silence(7.0, 50.01, simulated=False) is None
    watch.note(7.0, 50.02)
    assert watch.silence(7.3, 50.32, simulated=False) is not None


def test_when_the_clock_stands_two_seconds_of_wall_time_are_a_fault_but_in_a_simulation():
    watch = SampleWatch()
    watch.note(10.0, 50.0)
    assert watch.silence(10.0, 51.9, simulated=False) is None
    assert watch.silence(10.0, 52.1, simulated=False) == "no sensor sample for 2 s of wall time"
    assert watch.silence(10.0, 100.0, simulated=False) == "no sensor sample for 2 s of wall time"
    assert watch.silence(10.0, 90.0, simulated=True) is None


def test_the_latch_keeps_each_reason_once_until_it_is_released():
    latch = VentLatch()
    for k in range(50):
        latch.set(f"reason {k % 15}")
    assert len(latch.reasons) == 10 and latch
    latch.release()
    assert not latch
