"""The table of free angles against the exact integral."""

import copy
from dataclasses import replace

import numpy as np
import pytest

from softhand_model.chain.free_response import RestTable, SegmentResponse, segment_angles
from softhand_model.hand import section
from softhand_model.hand.actuator import load_actuator
from softhand_model.hand.profile import ConstantProfile, TableProfile
from softhand_model.model_file import Model

SEGMENTS = 5


def table_of(name):
    return RestTable(load_actuator(name), SEGMENTS, np.eye(SEGMENTS))


@pytest.mark.parametrize("name", ["P5", "P10.finger", "P10.thumb", "P10.PalmOuter"])
def test_table_is_exact_between_its_points(name):
    actuator, table = load_actuator(name), table_of(name)
    pressures = np.geomspace(1.0, 2.9 * actuator.max_pressure, 37)
    exact, slope = segment_angles(actuator, SEGMENTS, pressures)
    found = np.array([table.value(pressure) for pressure in pressures])
    gains = np.array([table.slope(pressure) for pressure in pressures])
    assert found == pytest.approx(exact, rel=1e-8)
    assert gains == pytest.approx(slope, rel=1e-5)


def test_segment_angles_add_up_to_the_tip_angle():
    finger = load_actuator("P10.finger")
    pressures = np.array([4e3, 31e3])
    angles, _ = segment_angles(finger, 7, pressures)
    assert angles.shape == (2, 7)
    assert angles.sum(axis=1) == pytest.approx(finger.tip_angle(pressures), rel=1e-9)


def test_gain_is_the_slope_of_the_exact_angles():
    finger, step = load_actuator("P10.finger"), 1.0
    (before, after), _ = segment_angles(finger, 4, np.array([30e3 - step, 30e3 + step]))
    _, slope = segment_angles(finger, 4, np.array([30e3]))
    assert slope[0] == pytest.approx((after - before) / (2 * step), rel=1e-6)


def test_suction_gives_no_angle_but_the_gain_at_zero():
    table = table_of("P10.finger")
    assert table.value(-500.0) == pytest.approx(np.zeros(SEGMENTS), abs=0)
    assert table.slope(-500.0) == pytest.approx(table.slope(0.0))


def test_far_beyond_the_limit_the_angle_goes_on_straight():
    """lambda -> s at large load, so the straight line stays within a percent."""
    finger = load_actuator("P10.finger")
    exact, _ = segment_angles(finger, SEGMENTS, np.array([10 * finger.max_pressure]))
    assert table_of("P10.finger").value(10 * finger.max_pressure) == pytest.approx(
        exact[0], rel=0.01
    )


def test_tables_are_shared_by_copies():
    table = table_of("P5")
    assert copy.deepcopy(table) is table


def test_a_wall_that_thins_towards_the_tip_bends_each_segment_as_its_own_wall_does():
    thinning = TableProfile((0.0, 0.09), (0.003, 0.0015))
    block = ConstantProfile(0.02)
    finger = replace(
        load_actuator("P10.finger"), height=block, width=block, wall=thinning, side_wall=thinning
    )
    (angles,), _ = segment_angles(finger, 90, np.array([30e3]))
    middles = (np.arange(90) + 0.5) * 0.001
    wall = thinning(middles)
    kappa = section.free_curvature(30e3, 0.02, 0.02, wall, wall, 67e3)
    assert angles == pytest.approx(0.001 * kappa, rel=1e-4)
    assert angles[-1] > 1.8 * angles[0]
    (through_effects,), _ = SegmentResponse(finger, 90, Model()).angles_and_slopes(np.array([30e3]))
    assert through_effects == pytest.approx(angles, rel=1e-9)
