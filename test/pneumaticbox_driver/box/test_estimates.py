"""Estimates of air mass that the measured pressure contradicts: said, and never without reason."""

import numpy as np
import pytest
from bottle_rig import BottleRig
from hand_rig import HandRig

from pneumaticbox_driver.box.diagnostics import Level, LinkState, ValveActivity, box_reports

KPA, MG = 1e3, 1e-6


def channel(rig):
    found = box_reports(rig.box, LinkState(sensors_seen=True), ValveActivity(len(rig.names)))
    return next(report for report in found if report.name == "channel a")


def fill_past_the_box(rig, gauge):
    """Inflate the bottles by hand, by another valve, until they hold a gauge pressure [Pa]."""
    while rig.plant.pressures.min() - rig.box.settings.ambient < gauge:
        rig.plant.step(2e-3, [1, 1], rig.volumes())
        rig.box.on_sample(rig.plant.time, rig.plant.read())
        rig.box.latch.release()


@pytest.mark.parametrize("volume", [30e-6, 500e-6])
def test_no_air_in_a_bottle_under_pressure_is_said_once(volume):
    rig = BottleRig(volume=volume).started()
    fill_past_the_box(rig, 71 * KPA)
    rig.run(3.0, 4e-3)
    report = channel(rig)
    assert report.level == Level.WARN
    assert "cannot be true at" in report.message and "of the volume at rest" in report.message
    assert sum("channel a: an air mass of" in note for note in rig.box.notes) == 1
    assert rig.box.estimates.wrong.all()


def test_more_air_than_any_actuator_holds_is_said_after_a_second():
    box = BottleRig().box
    check, pressures, known = box.estimates, np.full(2, 120 * KPA), np.array([True, True])
    mass, drift = np.array([500 * MG, 20 * MG]), np.full(2, 1 * MG)
    assert check.look(5.0, mass, drift, pressures, known) == []
    assert check.look(5.9, mass, drift, pressures, known) == []
    (said,) = check.look(6.1, mass, drift, pressures, known)
    assert said.startswith("channel a: an air mass of 500.0 mg above rest cannot be true at 19 kPa")
    assert check.look(6.2, mass, drift, pressures, known) == []
    check.look(6.3, mass, drift, pressures, ~known)
    assert not check.wrong.any()


def test_it_is_forgotten_when_the_estimate_is_possible_again():
    rig = BottleRig().started()
    fill_past_the_box(rig, 71 * KPA)
    rig.run(2.0, 4e-3)
    rig.box.vent()
    rig.run(4.0, 4e-3)
    assert not rig.box.estimates.wrong.any()
    assert "cannot be true" not in channel(rig).message


@pytest.mark.parametrize("compliance", [0.0, 0.8, 3.0])
@pytest.mark.parametrize("held", [0.7, 1.0, 2.0])
def test_volumes_that_are_pressed_or_pulled_are_possible(compliance, held):
    rig = BottleRig(compliance=compliance, limit=250 * KPA).started()
    for target in (20 * MG, 35 * MG, 5 * MG):
        rig.command(target, target)
        rig.run(1.5, 4e-3)
        rig.hold(held * rig.volume)
        rig.run(1.5, 4e-3)
        rig.hold(None)
        rig.run(0.5, 4e-3)
    assert not rig.box.estimates.wrong.any()
    assert not any("cannot be true" in note for note in rig.box.notes)


@pytest.mark.parametrize("give", [1.0, 0.0])
def test_a_hand_that_is_free_or_blocked_is_possible(give):
    rig = HandRig("rbo_hand_1_split", mode="pressure").started()
    rig.actuators.give = give
    for target in (60 * KPA, 10 * KPA):
        rig.command(list(rig.names), [target] * len(rig.names))
        rig.run(3.0)
    assert not any("cannot be true" in note for note in rig.box.notes)
    assert np.isfinite(rig.box.observer.mass).all()
