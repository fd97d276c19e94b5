"""A calibration inside the box: it alone commands the valves, and limits and latch still apply."""

import numpy as np
import pytest
from bottle_rig import BottleRig

from pneumaticbox_driver.calibration.recording import PulseRanges
from pneumaticbox_driver.calibration.run import CalibrationPlan, CalibrationRun

MG = 1e-6
BOTTLE = 0.1e-3  # [m3]


def begun(limit=150e3, supplies=2, **plan):
    rig = BottleRig(volume=BOTTLE, channels=2, limit=limit).started()
    pulses = PulseRanges(high_pressure=60e3, longest=0.4)
    plan = {"points": 24, "settling": 0.2, "leak_test": 0.0, "ranges": pulses, **plan}
    volumes = np.full(2, BOTTLE)
    run = CalibrationRun(rig.names, volumes, CalibrationPlan(supplies=supplies, **plan))
    rig.box.start_calibration(run)
    return rig, run


def run_until(rig, run, state, limit=120.0):
    end = rig.plant.time + limit
    while run.state != state and rig.plant.time < end:
        rig.run(0.2, 8e-3)
    assert run.state == state, run.message


def test_a_calibration_runs_to_its_end_and_its_coefficients_are_good_for_control():
    rig, run = begun()
    run_until(rig, run, "waiting")
    assert not rig.box.valves.any()
    rig.plant.set_supply(260e3)
    rig.run(1.0, 4e-3)
    rig.box.calibration.next()
    run_until(rig, run, "done")
    assert not rig.box.latch
    rig.box.observer.set_calibrations(run.result)
    rig.command(0.0, 0.0)
    rig.run(6.0, 4e-3)
    rig.command(40 * MG, 20 * MG)
    rig.run(5.0, 4e-3)
    np.testing.assert_allclose(rig.mass, [40 * MG, 20 * MG], atol=3 * MG)


def test_meanwhile_commands_modes_tare_and_a_second_calibration_are_refused():
    rig, run = begun()
    rig.run(0.5, 4e-3)
    calls = (
        lambda: rig.command(1e-5, 1e-5),
        lambda: rig.box.set_modes(["pressure"] * 2),
        rig.box.tare,
        lambda: rig.box.start_calibration(CalibrationRun(rig.names, np.full(2, BOTTLE))),
    )
    for call in calls:
        with pytest.raises(ValueError, match="a calibration is under way"):
            call()
    with pytest.raises(ValueError, match="does not wait"):
        rig.box.calibration.next()
    assert run.state == "running" and rig.box.calibration.run is run


def test_it_is_not_begun_vented_or_disabled_or_for_other_channels():
    rig = BottleRig(channels=2).started()
    run = CalibrationRun(("a", "c"), np.full(2, BOTTLE))
    with pytest.raises(ValueError, match=r"expected channels \['a', 'b'\], got \['a', 'c'\]"):
        rig.box.start_calibration(run)
    with pytest.raises(ValueError, match="no calibration is under way"):
        rig.box.calibration.next()
    rig.box.enable(False)
    with pytest.raises(ValueError, match="disabled: no calibration is begun"):
        rig.box.start_calibration(run)
    rig.box.vent()
    with pytest.raises(ValueError, match="vented until reset"):
        rig.box.start_calibration(run)


def test_a_pressure_limit_that_is_reached_ends_it_and_is_held():
    rig, run = begun(limit=20e3)
    run_until(rig, run, "failed", 40.0)
    assert "has reached its pressure limit" in run.message
    rig.run(1.0, 4e-3)
    assert (rig.box.pressures < 20e3).all()


@pytest.mark.parametrize(
    ("end", "reason"),
    [
        (lambda rig: rig.box.vent(), "vent was requested"),
        (lambda rig: rig.box.enable(False), "the box was disabled"),
        (lambda rig: rig.answer(np.array([np.nan, 1e5, 4e5])), "sensor a: not a number"),
        (lambda rig: rig.plant.reset(), "the clock was set back"),
    ],
)
def test_what_stops_the_box_ends_it(end, reason):
    rig, run = begun()
    rig.run(2.0, 4e-3)
    end(rig)
    rig.run(0.1, 4e-3)
    assert run.state == "failed" and reason in run.message


def test_silence_after_earlier_commands_does_not_end_it():
    rig = BottleRig(volume=BOTTLE, channels=2, limit=150e3, command_timeout=1.0).started()
    rig.command(5 * MG, 5 * MG)
    rig.run(0.5)
    pulses = PulseRanges(high_pressure=60e3, longest=0.4)
    plan = CalibrationPlan(supplies=1, points=24, settling=0.2, leak_test=0.0, ranges=pulses)
    rig.box.start_calibration(CalibrationRun(rig.names, np.full(2, BOTTLE), plan))
    rig.run(4.0, 4e-3)
    assert not rig.box.latch
    assert rig.box.calibration.under_way
