"""A calibration as a run: several supply pressures, leaks, faults, and the user in between."""

import numpy as np
import pytest

from pneumaticbox_driver.calibration.recording import Sample
from pneumaticbox_driver.calibration.run import CalibrationPlan, CalibrationRun
from softhand_model.gas import AMBIENT_PRESSURE, GAS_CONSTANT, ROOM_TEMPERATURE

CAPACITY = 0.5e-3 / (GAS_CONSTANT * ROOM_TEMPERATURE)  # of the bottle [kg/Pa]
SHORT = CalibrationPlan(points=24, supplies=2, settling=0.1, averaging=0.1, leak_test=0.0)


class Bottles:
    """Two bottles with linear outlets and inlets that choke: mass is conserved, flows are known.

    `leaks` are conductances [kg/(s Pa)], `stuck` is a channel whose inlet does not open.
    """

    def __init__(self, leaks=(0.0, 0.0), stuck=None, noise=60.0, start=20e3):
        self.leaks, self.stuck, self.noise = np.array(leaks), stuck, noise
        self.gauge, self.supply, self.time = np.full(2, start), 400e3, 0.0
        self.random = np.random.default_rng(1)

    def step(self, valves, dt=0.004):
        inlet = (np.asarray(valves) > 0) * (np.arange(2) != self.stuck)
        flow = inlet * 6e-11 * self.supply - (np.asarray(valves) < 0) * 2e-9 * self.gauge
        self.gauge = self.gauge + dt * (flow - self.leaks * self.gauge) / CAPACITY
        self.time += dt
        readings = self.gauge + AMBIENT_PRESSURE + self.random.normal(0, self.noise, 2)
        return Sample(self.time, readings, self.supply)

    def play(self, run, supplies=()):
        """Answer the run until it ends or waits with no supply pressure left; returns the waits."""
        valves, left, waits = np.zeros(2), list(supplies), 0
        while run.state in ("running", "waiting"):
            valves = run.on_sample(self.step(valves))
            if run.state == "waiting":
                waits += 1
                if not left:
                    break
                self.supply = left.pop(0)
                run.on_sample(self.step(np.zeros(2)))
                run.next()
        return waits


def fresh_run(plan=SHORT, **options):
    return CalibrationRun(("a", "b"), [0.5e-3, 0.5e-3], plan, **options)


def test_it_waits_for_a_supply_pressure_between_levels_and_is_done_after_the_last():
    run = fresh_run(CalibrationPlan(points=36, supplies=3, averaging=0.1, leak_test=0.0))
    assert Bottles().play(run, supplies=(420e3, 440e3)) == 2
    assert run.state == "done" and run.progress == 1.0
    for outlet, calibration in enumerate(run.result, start=1):
        assert calibration.outlet == outlet and calibration.points == 36
        low, high = calibration.supply_range
        assert high - low == pytest.approx(40e3)


def test_the_channels_are_vented_before_they_count_as_at_ambient_pressure():
    bottles, run = Bottles(start=80e3), fresh_run()
    valves = run.on_sample(bottles.step(np.zeros(2)))
    np.testing.assert_array_equal(valves, -1)
    bottles.play(run, supplies=(440e3,))
    assert run.state == "done"
    assert run.result[0].pressure_range[0] == pytest.approx(0.0, abs=300.0)


def test_while_it_waits_the_valves_are_closed_and_the_message_says_what_to_do():
    run = fresh_run()
    bottles = Bottles()
    bottles.play(run)
    assert run.state == "waiting"
    assert "then call pneumaticbox/calibrate_next" in run.message
    for _ in range(50):
        np.testing.assert_array_equal(run.on_sample(bottles.step(np.zeros(2))), 0)
    with pytest.raises(ValueError, match="turn it by 10 kPa or more"):
        run.next()
    assert run.state == "waiting"


def test_progress_only_grows_and_counts_pulses():
    run, bottles, seen = fresh_run(), Bottles(), []
    valves = np.zeros(2)
    while run.state == "running":
        valves = run.on_sample(bottles.step(valves))
        seen.append((run.progress, run.message))
    shares = [share for share, _ in seen]
    assert shares == sorted(shares) and 0.3 < shares[-1] < 0.5
    assert any("supply pressure 1 of 2 (299 kPa), pulse 6 of 6" in message for _, message in seen)


def test_fitted_aside_it_goes_on_taking_samples_and_finds_the_same():
    beside, at_once = fresh_run(aside=True), fresh_run()
    Bottles().play(at_once, supplies=(440e3,))
    bottles, messages = Bottles(), []
    bottles.play(beside)
    bottles.supply = 440e3
    beside.on_sample(bottles.step(np.zeros(2)))
    beside.next()
    valves = np.zeros(2)
    while beside.state == "running":
        valves = beside.on_sample(bottles.step(valves))
        messages.append(beside.message)
        if beside.message == "fitting the coefficients":
            np.testing.assert_array_equal(valves, 0)
    assert messages.count("fitting the coefficients") > 1
    assert beside.result == at_once.result


def test_an_aborted_run_closes_the_valves_and_has_no_result():
    run, bottles, valves = fresh_run(), Bottles(), np.zeros(2)
    while not (valves > 0).any():
        valves = run.on_sample(bottles.step(valves))
    run.abort("vented")
    np.testing.assert_array_equal(run.on_sample(bottles.step(valves)), 0)
    assert (run.state, run.message) == ("failed", "vented")
    with pytest.raises(ValueError, match="no result: failed, vented"):
        _ = run.result
    with pytest.raises(ValueError, match="does not wait: failed"):
        run.next()


def test_a_channel_whose_inlet_brings_nothing_is_named():
    run = fresh_run()
    Bottles(stuck=1).play(run, supplies=(440e3,))
    assert run.state == "failed"
    assert "channel b: the pressure does not rise with the inlet open" in run.message


def test_a_reading_that_is_no_number_ends_it():
    run = fresh_run()
    run.on_sample(Sample(0.0, np.array([np.nan, 101e3]), 400e3))
    assert run.state == "failed" and "not a number" in run.message


def test_one_supply_pressure_only_fails_with_the_terms_it_cannot_tell():
    run = fresh_run(CalibrationPlan(points=24, supplies=1, averaging=0.1, leak_test=0.0))
    Bottles().play(run)
    assert run.state == "failed"
    assert "channel a: pulses do not separate" in run.message and "switch_in" in run.message


def test_a_leak_is_found_within_three_errors_and_a_tight_channel_has_none():
    plan = CalibrationPlan(points=24, supplies=2, averaging=0.1, settling=0.1, leak_test=20.0)
    run = fresh_run(plan)
    true = 3e-12
    Bottles(leaks=(true, 0.0)).play(run, supplies=(440e3,))
    leaky, tight = (calibration.leak for calibration in run.result)
    assert 0 < leaky.error < 0.1 * true
    assert abs(leaky.conductance - true) < 3 * leaky.error + 0.02 * true
    assert tight.conductance == 0.0 and tight.error > 0


def test_what_leaked_during_a_pulse_is_not_taken_for_the_valve_s():
    plan = CalibrationPlan(points=80, supplies=2, averaging=0.4, leak_test=20.0)
    runs = [fresh_run(plan), fresh_run(plan)]
    Bottles(leaks=(2e-11, 0.0), noise=1.0).play(runs[0], supplies=(440e3,))
    Bottles(noise=1.0).play(runs[1], supplies=(440e3,))
    masses = []
    for run in runs:
        inflate = run.result[0].inflate.as_array()
        masses.append(inflate @ [1.0, 0.3 * 250e3, 0.3 * 400e3 * 0.484, 400e3, 150e3])
    # the leak takes 0.9 mg off a pulse at 49 kPa
    assert masses[0] == pytest.approx(masses[1], abs=0.1e-6)


@pytest.mark.parametrize(
    ("arguments", "expected"),
    [
        ({"points": 20}, "points must be at least 24 for 2 supply pressures, got 20"),
        ({"supplies": 0}, "supplies must be at least 1, got 0"),
        ({"averaging": 0.0}, "averaging must be above 0 s, got 0.0"),
        ({"leak_test": -1.0}, "leak_test must be 0 s or above, got -1.0"),
    ],
)
def test_a_plan_that_cannot_be_played_is_refused_by_name(arguments, expected):
    with pytest.raises(ValueError) as error:
        CalibrationPlan(**arguments)
    assert str(error.value) == expected


def test_volumes_must_be_one_a_channel():
    with pytest.raises(ValueError, match="volumes must be 2 above 0 m3, one per channel"):
        CalibrationRun(("a", "b"), [0.5e-3])
