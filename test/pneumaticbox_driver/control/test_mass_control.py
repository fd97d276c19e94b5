"""Bang-bang mass control on the bench: lands within the smallest pulse, without chattering."""

from itertools import pairwise

import numpy as np
import pytest
from bottle_rig import BottleRig

from pneumaticbox_driver.box.commands import TrajectoryPoint

MG = 1e-6
SETTLING = 2.5
BOTTLE = {"volume": 0.5e-3, "compliance": 0.0}
RIGID = {"volume": 30e-6, "compliance": 0.0}
FINGER = {"volume": 30e-6, "compliance": 0.8}  # nearly doubles at 40 kPa


@pytest.mark.parametrize("dt", [2e-3, 1e-2], ids=["2 ms", "10 ms"])
@pytest.mark.parametrize("load", [BOTTLE, RIGID, FINGER], ids=["bottle", "rigid", "finger"])
def test_up_and_down_the_true_mass_ends_within_the_smallest_pulse(load, dt):
    rig = BottleRig(channels=4, seed=3, **load).started(dt)
    for target in (5 * MG, 20 * MG, 12 * MG, 4 * MG, 15 * MG):
        rig.command(*[target] * 4)
        rig.run(SETTLING, dt)
        assert (np.abs(rig.mass - target) < rig.smallest_pulses()).all()


def test_a_step_takes_one_pulse_and_then_the_valves_rest():
    rig = BottleRig(channels=4, **FINGER).started()
    for target in (15 * MG, 5 * MG):
        rig.openings[:] = 0
        rig.command(*[target] * 4)
        rig.run(2 * SETTLING)
        assert (rig.openings <= 2).all()
        assert rig.switchings[-1][0] < rig.plant.time - SETTLING


def test_targets_below_half_a_smallest_pulse_away_move_nothing():
    rig = BottleRig(channels=2, **FINGER).started()
    rig.command(15 * MG, 15 * MG)
    rig.run(SETTLING)
    rig.openings[:] = 0
    rig.command(15.3 * MG, 14.4 * MG)
    rig.run(SETTLING)
    assert not rig.openings.any()


def test_every_pulse_and_every_pause_is_as_long_as_the_valves_need():
    rig = BottleRig(channels=2, **FINGER).started()
    times = np.linspace(0.2, 8.0, 40)
    points = [TrajectoryPoint(t, [(12 + 10 * np.sin(2 * t)) * MG, 8 * MG]) for t in times]
    rig.box.command(rig.names, points, 0.0, rig.box.time)
    rig.run(9.0)
    sine = [entry for entry in rig.switchings if entry[1] == 0]
    assert len(sine) > 12
    settings = rig.box.settings
    for (start, _, valve), (end, _, after) in pairwise(sine):
        least = settings.shortest_pulse if valve else settings.shortest_pause
        assert end - start > least - 1e-6
        assert valve == 0 or after == 0


def test_a_sine_is_followed_within_two_smallest_pulses():
    rig = BottleRig(channels=2, **FINGER).started()
    start = rig.box.time
    times = np.arange(0.1, 12.0, 0.1)
    points = [TrajectoryPoint(t, [(15 - 10 * np.cos(t)) * MG] * 2) for t in times]
    rig.box.command(rig.names, points, 0.0, start)
    rig.run(2.0)
    while rig.box.time < start + 11.5:
        rig.run(0.1)
        target = (15 - 10 * np.cos(rig.box.time - start)) * MG
        assert (np.abs(rig.mass - target) < 2 * rig.smallest_pulses() + 1 * MG).all()


def test_a_target_of_zero_empties_the_channel_and_zeroes_the_estimate():
    rig = BottleRig(channels=3, **FINGER).started()
    rig.command(*[20 * MG] * 3)
    rig.run(SETTLING)
    rig.command(0.0, -5 * MG, 20 * MG)
    rig.run(SETTLING)
    np.testing.assert_allclose(rig.mass[:2], 0.0, atol=0.05 * MG)
    np.testing.assert_array_equal(rig.box.observer.mass[:2], 0.0)
    assert not rig.box.valves.any()
    assert rig.mass[2] == pytest.approx(20 * MG, abs=1 * MG)


def test_compliant_motion_with_closed_valves_calls_for_no_action():
    rig = BottleRig(channels=1, **RIGID).started()
    rig.command(15 * MG)
    rig.run(SETTLING)
    rig.openings[:] = 0
    before, mass = rig.box.pressures.copy(), rig.mass.copy()
    rig.volume *= 0.8  # an external push
    rig.run(1.0)
    assert rig.box.pressures[0] > before[0] + 20e3
    assert not rig.openings.any()
    np.testing.assert_allclose(rig.mass, mass, atol=1e-12)
