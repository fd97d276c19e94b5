"""Experiments that could come next: within the limits of the bench, one change at a time."""

import numpy as np
import pytest
from lab_sets import measured, run, specimen

from model_lab.bench.synthesize import synthesize
from model_lab.bench.trial_runs import run_of, trial_runs
from model_lab.experiments.forward import Forward
from model_lab.measurements.measurement_set import MeasurementSet, Specimen

TIME = np.linspace(0.0, 12.0, 50)
RAMP = 30e3 * np.interp(TIME, [0.0, 6.0, 12.0], [0.0, 1.0, 0.0])


def bending(*specimens):
    runs = [run(one.name, TIME, of=one.name, pressure=RAMP) for one in specimens]
    return measured("free_bending", runs, *specimens)


def test_no_trial_exceeds_the_pressure_so_far_and_none_rises_faster_than_in_a_second():
    for trial in trial_runs(bending(specimen()), "pneuflex"):
        pressure, time = trial.columns["pressure"], trial.columns["time"]
        assert pressure[0] == 0.0
        assert pressure.max() <= 30e3 * (1.0 + 1e-9)
        assert np.abs(np.diff(pressure) / np.diff(time)).max() <= 30e3 * 1.001


def test_every_trial_changes_one_thing_at_the_most():
    found = {trial.changes for trial in trial_runs(bending(specimen()), "pneuflex")}
    assert found == {
        (),
        ("20 K warmer",),
        ("mounted base up",),
        ("mounted base down",),
        ("mounted level curling up",),
        ("mounted level curling down",),
        ("another specimen, like d2.5 with a wall of 4 mm",),
    }


def test_a_new_wall_is_only_proposed_where_the_set_has_one():
    both = bending(specimen(), specimen("d4", wall=0.004))
    assert not any("wall" in words for t in trial_runs(both, "pneuflex") for words in t.changes)
    thick = [t for t in trial_runs(bending(specimen(wall=0.008)), "pneuflex") if t.changes]
    walls = {float(t.specimen.values["wall"]) for t in thick}
    assert walls == {0.008, 0.005}  # a thicker one would not leave a chamber


def test_other_makes_are_neither_turned_over_nor_cast_anew():
    found = {trial.changes for trial in trial_runs(bending(specimen()), "linear")}
    assert found == {(), ("20 K warmer",)}


def test_strips_begin_at_rest_and_stay_within_their_stretch():
    stretch = 1.0 + np.interp(TIME, [0.0, 6.0, 12.0], [0.0, 0.8, 0.0])
    bar = Specimen("bar", {"gauge_length": 0.03, "shear_modulus": 67e3}, batch="A")
    data = measured("uniaxial", [run("r", TIME, of="bar", stretch=stretch)], bar)
    found = trial_runs(data, "pneuflex")
    assert found
    for trial in found:
        values = trial.columns["stretch"]
        assert values[0] == 1.0 and values.max() == pytest.approx(
            1.8, abs=0.03
        )  # corners fall between samples


@pytest.mark.parametrize("experiment", ["valve_pulse", "base_torque"])
def test_pulses_and_held_tips_can_be_predicted(experiment):
    data = synthesize(experiment, 0, hide=False).data
    found = trial_runs(data, "pneuflex")
    assert len({trial.protocol for trial in found}) > 1
    runs = tuple(run_of(t, f"t{i}", data.outputs) for i, t in enumerate(found[:2]))
    planned = MeasurementSet(experiment, "", data.specimens, runs)
    calibration = {"inflate": 7e-11, "deflate": 6e-10}
    forward = Forward(planned, "pneuflex", calibration=calibration, free_calibration=False)
    predicted = forward.predict(np.zeros((1, 0)))
    assert np.isfinite(predicted).all() and np.abs(predicted).max() > 0.0


def test_a_ramp_is_slow_only_if_it_is_slower_than_all_runs_so_far():
    trials = trial_runs(bending(specimen()), "pneuflex")
    lasting = {
        name: [t.columns["time"][-1] for t in trials if t.protocol == name]
        for name in ("ramp", "slow_ramp")
    }
    assert max(lasting["ramp"]) < TIME[-1] <= min(lasting["slow_ramp"]) * 1.001
