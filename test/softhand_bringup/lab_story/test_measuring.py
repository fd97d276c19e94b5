"""Plateaus of pressure as setpoints of air mass."""

import dataclasses
import itertools

import pytest

from softhand_bringup.lab_story.measuring import (
    CHECK_PLAN,
    FULL_PLAN,
    RISE_TIME,
    Measurement,
    air_mass_setpoints,
    enclosed_air,
)
from softhand_model.hand.actuator import load_actuator

FINGER = load_actuator("P10.finger")
SPECIFIC_GAS_CONSTANT, ROOM, AMBIENT = 287.05, 293.15, 101_325.0  # of dry air [J/(kg K)], [K], [Pa]


def test_air_in_a_finger_that_cannot_bend_is_that_of_an_ideal_gas_in_its_volume():
    stiff = dataclasses.replace(FINGER, shear_modulus=1e13)
    volume = stiff.chamber_volume() + stiff.supply_volume
    expected = 25e3 * volume / (SPECIFIC_GAS_CONSTANT * ROOM)
    assert enclosed_air(stiff, 25e3) == pytest.approx(expected, rel=1e-3)


def test_a_finger_that_bends_takes_the_air_of_its_growing_chamber_too():
    # virtual work without friction: what the air does is stored, so the chamber can only grow
    pressures = (0.0, 5e3, 10e3, 20e3, 30e3)
    stiff = dataclasses.replace(FINGER, shear_modulus=1e13)
    extra = [enclosed_air(FINGER, p) - enclosed_air(stiff, p) for p in pressures]
    assert extra[0] == pytest.approx(0.0, abs=1e-12)
    assert all(later > 1.5 * sooner for sooner, later in itertools.pairwise(extra[1:]))


def test_a_course_holds_every_plateau_and_ends_with_the_last():
    measurement = Measurement("up_and_down", (10e3, 20e3, 0.0), 1.5)
    setpoints = air_mass_setpoints(FINGER, measurement)
    low, high = enclosed_air(FINGER, 10e3), enclosed_air(FINGER, 20e3)
    assert [time for time, _ in setpoints] == pytest.approx(
        [0, RISE_TIME, 1.5, 1.5 + RISE_TIME, 3, 3 + RISE_TIME]
    )
    assert [mass for _, mass in setpoints] == pytest.approx([0, low, low, high, high, 0], abs=1e-12)
    assert measurement.duration == 4.5


@pytest.mark.parametrize("plan", [FULL_PLAN, CHECK_PLAN], ids=["whole", "check"])
def test_every_measurement_of_a_plan_leaves_time_at_its_plateaus_and_ends_empty(plan):
    for measurement in plan.measurements:
        assert measurement.hold > 4 * RISE_TIME
        assert measurement.levels[-1] == 0.0
        assert max(measurement.levels) <= 30e3
    names = [measurement.protocol for measurement in plan.measurements]
    assert len(set(names)) == len(names) >= 2
