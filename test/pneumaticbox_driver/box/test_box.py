"""The box as a whole on the bench: start, tare, limits, faults, and what leaves the safe state."""

import numpy as np
import pytest
from bottle_rig import BottleRig, Swelling

from pneumaticbox_driver.box.commands import TrajectoryPoint
from softhand_model.gas import AMBIENT_PRESSURE

MG = 1e-6


def filled(**options):
    rig = BottleRig(channels=2, **options).started()
    rig.command(15 * MG, 15 * MG)
    rig.run(2.0)
    assert rig.mass.min() > 13 * MG
    return rig


# start and tare


def test_the_start_takes_away_the_offsets_of_the_sensors():
    rig = BottleRig(channels=8)
    rig.run(0.5)
    assert rig.box.zeroing.ready and rig.box.zeroing.empty.all()
    raw = np.mean([rig.plant.read() for _ in range(400)], axis=0)[:-1] - AMBIENT_PRESSURE
    assert np.abs(raw).max() > 500.0
    assert np.abs(raw - rig.box.zeroing.offsets).max() < 30.0


def test_a_command_before_the_sensors_are_averaged_is_kept_for_afterwards():
    rig = BottleRig(channels=2)
    rig.run(0.02)
    rig.command(15 * MG, 5 * MG)
    rig.run(0.05)
    assert not rig.box.zeroing.ready and not rig.box.valves.any()
    rig.run(3.0)
    np.testing.assert_allclose(rig.mass, [15 * MG, 5 * MG], atol=2 * MG)


def test_a_start_under_pressure_takes_the_mass_of_the_free_volume():
    rig = BottleRig(channels=2, volume=0.5e-3)
    rig.plant.fill(rig.rest + np.array([60 * MG, 0.0]))
    rig.run(1.5)
    assert rig.box.observer.mass[0] == pytest.approx(60 * MG, rel=0.35)  # the sensor's class
    assert rig.box.observer.mass[1] == 0.0
    assert any("under pressure" in note and "'a'" in note for note in rig.box.notes)


def test_tare_takes_the_drift_away():
    rig = filled(volume=0.1e-3)
    rig.box.enable(False)
    rig.box.observer.set_mass(0, 22 * MG)  # as after many pulses
    rig.run(0.5)
    sentence = rig.box.tare()
    assert "by free volume: ['a', 'b']" in sentence
    np.testing.assert_allclose(rig.box.observer.mass, rig.mass, atol=0.4 * MG)


def test_tare_is_refused_while_valves_are_open_or_pressures_move():
    rig = BottleRig(channels=2).started()
    rig.command(25 * MG, 25 * MG)
    rig.run(0.2)
    with pytest.raises(ValueError, match="valves are open"):
        rig.box.tare()
    rig.box.enable(False)
    rig.run(0.08)
    with pytest.raises(ValueError, match="are not constant yet"):
        rig.box.tare()


def held_open():
    """A rig whose actuators were emptied while something kept them bent by 9 cm3."""
    finger = {"volume": 30e-6, "compliance": 0.8}
    rig = filled(model=Swelling(**finger, channels=2), volume_model="hand", **finger)
    rig.hold(rig.volume + 9e-6)
    rig.command(0.0, 0.0)
    rig.run(2.0)
    return rig


def test_a_channel_emptied_while_held_open_keeps_what_is_left_until_it_is_free():
    rig = held_open()
    assert rig.mass.min() > 5 * MG
    assert not rig.box.valves.any()
    np.testing.assert_allclose(rig.box.observer.mass, rig.mass, atol=1.5 * MG)
    rig.hold(None)
    rig.run(2.0)
    np.testing.assert_allclose(rig.mass, 0.0, atol=0.2 * MG)
    np.testing.assert_array_equal(rig.box.observer.mass, 0.0)
    assert not rig.box.notes


def test_what_is_left_in_a_held_channel_counts_for_the_next_target():
    rig = held_open()
    rig.command(20 * MG, 20 * MG)
    rig.hold(None)
    rig.run(2.0)
    np.testing.assert_allclose(rig.mass, 20 * MG, atol=2 * MG)


def test_a_channel_that_stays_at_ambient_pressure_is_taken_for_one_at_rest():
    rig = held_open()
    rig.run(5.0)
    np.testing.assert_array_equal(rig.box.observer.mass, 0.0)
    (note,) = [note for note in rig.box.notes if "channel a" in note]
    assert "at ambient pressure for 5 s: zeroed" in note


# limits


def test_a_target_beyond_the_limit_stays_below_it_without_chattering():
    rig = BottleRig(channels=2, limit=30e3).started()
    rig.command(100 * MG, 5 * MG)
    peak = 0.0
    for _ in range(400):
        rig.run(0.01)
        peak = max(peak, rig.plant.pressures[0] - AMBIENT_PRESSURE)
    assert peak < 1.2 * 30e3
    assert rig.plant.pressures[0] - AMBIENT_PRESSURE < 30e3
    assert rig.openings[0] <= 3
    assert not rig.box.latch
    assert rig.mass[1] == pytest.approx(5 * MG, abs=1 * MG)


def test_a_command_that_is_repeated_does_not_fill_again_what_was_relieved():
    rig = BottleRig(channels=2, limit=30e3).started()
    rig.command(40 * MG, 5 * MG)
    rig.run(2.0)
    assert rig.box.guard.blocked.tolist() == [True, False]
    openings = rig.openings[0]
    for _ in range(10):
        rig.command(40 * MG, 5 * MG)
        rig.run(0.2)
    assert rig.openings[0] == openings
    rig.command(41 * MG, 5 * MG)  # another target may try it again
    rig.run(0.2)
    assert rig.openings[0] > openings


def test_a_command_for_later_does_not_fill_what_was_relieved_before_its_time():
    rig = BottleRig(channels=2, limit=30e3).started()
    rig.command(40 * MG, 5 * MG)
    rig.run(2.0)
    now, point = rig.box.time, TrajectoryPoint(0.0, positions=(41 * MG, 5 * MG))
    rig.box.command(rig.box.settings.channels, [point], now + 0.1, now)
    rig.run(0.09)
    assert rig.box.guard.blocked.tolist() == [True, False]
    rig.run(0.02)
    assert rig.box.guard.blocked.tolist() == [False, False]


def test_a_push_over_the_limit_is_relieved():
    rig = filled(limit=60e3)
    rig.volume *= 0.7
    rig.run(1.0)
    assert (rig.plant.pressures - AMBIENT_PRESSURE < 60e3).all()


def test_a_pressure_that_relief_does_not_hold_vents_everything():
    rig = filled(limit=60e3)
    rig.plant.fill(2.2 * rig.plant.mass)
    rig.run(0.05)
    assert "far above its limit" in rig.box.latch.reasons[0]
    assert rig.box.valves.tolist() == [-1, -1]


# faults


@pytest.mark.parametrize("entry", [0, 1, 2])
def test_a_sensor_that_gives_no_number_vents_at_once_and_latches(entry):
    rig = filled()
    readings = rig.plant.read()
    readings[entry] = np.nan
    rig.answer(readings)
    assert rig.box.valves.tolist() == [-1, -1]
    rig.run(2.0)
    assert rig.box.latch.reasons == [f"sensor {['a', 'b', 'supply'][entry]}: not a number"]
    np.testing.assert_allclose(rig.mass, 0.0, atol=0.05 * MG)
    np.testing.assert_array_equal(rig.box.observer.mass, 0.0)


def test_a_box_whose_first_sample_is_no_number_vents_and_can_still_be_reset():
    rig = BottleRig(channels=1)
    rig.answer(np.array([np.nan, 4e5]))
    with pytest.raises(ValueError, match="expected a sensor sample with a number"):
        rig.box.reset()
    rig.run(1.5)
    rig.box.reset()
    rig.command(10 * MG)
    rig.run(2.0)
    assert rig.mass[0] == pytest.approx(10 * MG, abs=1 * MG)


def test_a_gap_in_the_samples_vents_and_latches():
    rig = filled()
    rig.plant.step(0.3, [0, 0], rig.volumes())
    rig.run(0.01)
    assert rig.box.latch.reasons == ["no sensor sample for 250 ms"]
    assert rig.box.valves.tolist() == [-1, -1]


def test_a_clock_set_back_starts_anew_without_latching():
    rig = BottleRig(channels=2).started()
    rig.command(15 * MG, 15 * MG)
    rig.run(2.0)
    rig.plant.reset()
    rig.watch.reset(0.0)
    rig.run(1.0)
    assert not rig.box.latch and not rig.box.valves.any()
    assert any("clock was set back" in note for note in rig.box.notes)
    np.testing.assert_array_equal(rig.box.observer.mass, 0.0)
    rig.command(10 * MG, 10 * MG)
    rig.run(2.0)
    np.testing.assert_allclose(rig.mass, 10 * MG, atol=1 * MG)


def test_a_clock_set_back_in_the_midst_of_it_latches_too():
    rig = BottleRig(channels=2).started()
    rig.command(15 * MG, 15 * MG)
    rig.run(2.0)
    rig.plant.time -= 1.5
    rig.run(0.01)
    assert rig.box.valves.tolist() == [-1, -1]
    assert rig.box.latch.reasons[0].startswith("the clock was set back by 1.4")
    rig.run(1.0)
    rig.box.reset()
    assert not rig.box.latch


def test_a_repeated_stamp_repeats_the_answer():
    rig = filled()
    rig.command(30 * MG, 30 * MG)
    rig.run(0.02)
    before = rig.box.valves.copy()
    again = rig.box.on_sample(rig.box.time, np.array([9e5, 9e5, 1e5]))
    np.testing.assert_array_equal(again, before)
    assert not rig.box.latch


def test_a_vent_holds_though_the_next_sample_has_the_same_stamp():
    rig = filled()
    rig.command(30 * MG, 30 * MG)
    rig.run(0.02)
    assert rig.box.valves.max() == 1
    rig.box.vent()
    assert rig.box.on_sample(rig.box.time, np.array([1e5, 1e5, 4e5])).tolist() == [-1, -1]


def test_silence_of_commands_holds_the_target_unless_a_timeout_is_set():
    holding = filled()
    holding.run(6.0)
    assert not holding.box.latch and holding.mass.min() > 13 * MG
    strict = BottleRig(channels=2, command_timeout=1.0).started()
    strict.run(2.0)
    assert not strict.box.latch
    strict.command(5 * MG, 5 * MG, after=2.0)
    strict.run(2.9)
    assert not strict.box.latch
    strict.run(0.3)
    assert strict.box.latch.reasons == ["no command for 1.0 s"]


def test_silence_of_commands_is_no_fault_once_the_last_one_has_let_the_air_out():
    rig = filled(command_timeout=2.5)
    rig.command(0.0, 0.0)
    rig.run(4.0)
    assert not rig.box.latch
    rig.command(0.0, 10 * MG)
    rig.run(3.0)
    assert rig.box.latch.reasons == ["no command for 2.5 s"]


def test_commands_that_are_repeated_keep_the_air():
    rig = filled(command_timeout=2.5)
    for _ in range(4):
        rig.command(15 * MG, 15 * MG)
        rig.run(1.0)
    assert not rig.box.latch and rig.mass.min() > 13 * MG


# vent, reset, enable


def test_vent_empties_and_stays_until_reset_and_commands_are_refused_meanwhile():
    rig = filled()
    rig.box.vent()
    rig.run(2.0)
    np.testing.assert_allclose(rig.mass, 0.0, atol=0.05 * MG)
    with pytest.raises(ValueError, match="vented until reset"):
        rig.command(10 * MG, 10 * MG)
    rig.run(1.0)
    assert rig.box.valves.tolist() == [-1, -1]
    rig.box.reset()
    rig.run(0.2)
    assert rig.box.valves.tolist() == [0, 0]
    assert np.isnan(rig.box.commands.setpoints.at(rig.box.time)).all()
    rig.command(10 * MG, 10 * MG)
    rig.run(2.0)
    np.testing.assert_allclose(rig.mass, 10 * MG, atol=1 * MG)


def test_vented_it_is_not_enabled_before_a_reset():
    rig = BottleRig(start_enabled=False).started()
    rig.box.vent()
    with pytest.raises(ValueError, match="vent was requested.*pneumaticbox/reset must come first"):
        rig.box.enable(True)
    assert rig.box.reset() == "valves are closed, disabled until pneumaticbox/enable"
    with pytest.raises(ValueError, match="disabled"):
        rig.command(10 * MG, 10 * MG)
    assert rig.box.enable(True) == "commands are taken"
    rig.command(10 * MG, 10 * MG)
    rig.box.vent()
    assert rig.box.enable(False) == "disabled: outlets stay open"


def test_disabled_the_valves_close_and_commands_are_refused():
    rig = BottleRig(channels=2).started()
    rig.command(30 * MG, 30 * MG)
    rig.run(0.3)
    rig.box.enable(False)
    rig.run(0.1)
    assert not rig.box.valves.any()
    with pytest.raises(ValueError, match="disabled"):
        rig.command(10 * MG, 10 * MG)
    rig.box.enable(True)
    rig.run(0.5)
    assert not rig.box.valves.any()


def test_a_refused_command_changes_nothing():
    rig = filled()
    before = rig.box.commands.setpoints.at(rig.box.time).copy()
    with pytest.raises(ValueError, match="expected a finite number"):
        rig.command(5 * MG, float("nan"))
    np.testing.assert_array_equal(rig.box.commands.setpoints.at(rig.box.time), before)


def test_a_calibration_of_another_number_of_channels_is_refused():
    rig = BottleRig(channels=2)
    with pytest.raises(ValueError, match="calibrations must be 2, one per channel, got 0"):
        type(rig.box)(rig.box.settings, [])
