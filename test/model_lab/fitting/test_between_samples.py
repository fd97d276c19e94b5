"""What an input did between samples is seen from what lags behind it."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import lfilter

from model_lab.diagnosis.diagnose import diagnose
from model_lab.experiments.forward import Forward
from model_lab.fitting.between_samples import with_input_between
from model_lab.fitting.notices import notices
from model_lab.fitting.problem import pose_problem
from model_lab.measurements.held_input import jumps, with_jumps
from model_lab.measurements.measurement_set import MeasurementSet, Run, Specimen
from softhand_model.effects import effect_classes
from softhand_model.model_file import load_model

SAMPLES, APART, FINER = 121, 0.1, 1000  # [s] between samples; steps from one to the next
LAG = 0.15  # [s]
NOISE = 2e-3  # [rad]
LAGS = ("tube_lag", "viscoelasticity", "angle_sensor_lag", "clock_offset")
SIZES = {"length": 0.09, "height": 0.02, "width": 0.02, "wall": 0.003, "side_wall": 0.003}


def steps(random):
    """Levels [Pa], each held for some samples (SAMPLES,)."""
    levels = np.repeat(45e3 * random.uniform(0.0, 1.0, SAMPLES), random.integers(3, 9, SAMPLES))
    levels[:3] = 0.0
    return levels[:SAMPLES]


def between(shown, held):
    """What the input (SAMPLES,) was on a fine grid."""
    fine = np.arange((SAMPLES - 1) * FINER + 1) / FINER
    if held:
        return shown[np.floor(fine + 1e-9).astype(int)]
    return np.interp(fine, np.arange(SAMPLES), shown)


def follow(values, lag):
    """First-order lag of what is held over each fine step."""
    left = np.exp(-APART / FINER / lag)
    return np.asarray(lfilter([0.0, 1.0 - left], [1.0, -left], values))


def made(held=True, lag=LAG, protocols=4, smooth=False):
    """Runs of a finger, each repeated, whose chamber lags behind its gauge."""
    random, runs = np.random.default_rng(0), []
    time = APART * np.arange(SAMPLES)
    for index in range(2 * protocols):
        if index % 2 == 0:
            shown = 4e4 * np.sin(0.3 * (index + 1) * time) ** 2 if smooth else steps(random)
        columns = {"time": time, "pressure": shown, "tip_angle": np.zeros(SAMPLES)}
        runs.append(Run(f"r{index}", "s", f"p{index // 2}", 293.15, columns))
    specimen = Specimen("s", {**SIZES, "shear_modulus": 67e3, "mass": 0.035})
    data = MeasurementSet("free_bending", "", {"s": specimen}, tuple(runs))
    chamber = [
        follow(between(run.columns["pressure"], held), lag)[::FINER]
        if lag
        else run.columns["pressure"]
        for run in runs
    ]
    acts = replace(
        data,
        runs=tuple(
            replace(run, columns={**run.columns, "pressure": pressure})
            for run, pressure in zip(runs, chamber, strict=True)
        ),
    )
    angle = Forward(acts).predict(np.ones((1, 1)))[0] + NOISE * random.standard_normal(
        len(runs) * SAMPLES
    )
    shown = zip(runs, np.split(angle, len(runs)), strict=True)
    return replace(
        data, runs=tuple(replace(r, columns={**r.columns, "tip_angle": y}) for r, y in shown)
    )


def judged(data):
    return pose_problem(data, load_model("base"), {})[0].data.jumps


@pytest.mark.parametrize("held", [True, False])
def test_a_lag_near_the_distance_of_the_samples_is_found_whatever_the_input_did(held):
    data = made(held)
    known = {name: effect_classes()[name] for name in LAGS}
    found = diagnose(data, load_model("base"), known)
    assert found.problem.data.jumps is held
    (effect,) = found.diagnosis.effects
    low, high = effect.parameters["time_constant"].interval
    assert effect.name == "tube_lag" and low < LAG < high and high - low < 0.02
    assert ("held_input" in {notice.kind for notice in found.notices}) is held


def test_an_input_without_jumps_goes_straight():
    assert not judged(made(smooth=True))
    assert not jumps(made(smooth=True), made(smooth=True).runs[0]).size


def test_where_nothing_lags_the_input_counts_as_straight():
    assert not judged(made(lag=0.0))


def test_sets_of_pulses_and_sets_without_time_have_no_jumps():
    data = made()
    pulses = replace(data, experiment="valve_pulse")
    assert not jumps(pulses, data.runs[0]).size
    columns = {name: data.runs[0].columns[name] for name in ("pressure", "tip_angle")}
    timeless = replace(data, runs=(replace(data.runs[0], columns=columns),))
    assert with_input_between(timeless, lambda _: pytest.fail("asked")) is timeless


def test_a_jump_gets_a_sample_of_what_was_held_just_before_it():
    data = made()
    held, own = with_jumps(data)
    at = jumps(data, data.runs[0])
    first = held.runs[0].columns
    assert held.runs[0].samples == SAMPLES + len(at)
    assert np.array_equal(first["pressure"][own[:SAMPLES]], data.runs[0].columns["pressure"])
    just_before = own[at] - 1
    assert np.array_equal(first["pressure"][just_before], data.runs[0].columns["pressure"][at - 1])
    apart = first["time"][own[at]] - first["time"][just_before]
    assert np.all(apart > 0.0) and np.all(apart < 1e-5 * APART)


def test_jumps_are_said_and_marked():
    data = replace(made(), jumps=True)
    problem = pose_problem(data, load_model("base"), {})[0]
    found = {n.kind: n for n in notices(problem.data, problem.floor, np.zeros(data.table.samples))}
    notice = found["held_input"]
    assert notice.value == sum(len(jumps(data, run)) for run in data.runs)
    assert len(notice.marked) and "constant between its jumps" in notice.text


@pytest.mark.parametrize("lag", [0.0, 0.2])
def test_the_steps_of_a_coarse_sensor_are_no_lag(lag):
    """A lag and a late clock smooth the steps; together they do not even shift them."""
    random, time = np.random.default_rng(7), np.arange(0.0, 20.0, 0.05)
    specimen = Specimen("s", {**SIZES, "shear_modulus": 67e3, "mass": 0.035})
    fine = np.arange(0.0, 20.0, 0.001)
    shown, true = [], []
    for index, peak in enumerate([18e3] * 3 + [34e3] * 3):
        ramp = peak * (1.0 - np.abs(fine / 10.0 - 1.0))
        left = np.exp(-0.001 / lag) if lag else 0.0
        behind = lfilter([1.0 - left], [1.0, -left], ramp)[::50] if lag else ramp[::50]
        columns = {"time": time, "pressure": behind, "tip_angle": np.zeros(len(time))}
        true.append(Run(f"r{index}", "s", f"p{index // 3}", 293.15, columns))
        shown.append({**columns, "pressure": 500.0 * np.round(ramp[::50] / 500.0)})
    data = MeasurementSet("free_bending", "", {"s": specimen}, tuple(true))
    angles = np.split(Forward(data).predict(np.ones((1, 1)))[0], len(true))
    runs = tuple(
        replace(run, columns={**read, "tip_angle": y + 4e-3 * random.standard_normal(len(time))})
        for run, read, y in zip(true, shown, angles, strict=True)
    )
    known = {name: effect_classes()[name] for name in LAGS}
    found = diagnose(replace(data, runs=runs), load_model("base"), known).diagnosis
    assert found.verdict == ("effects_missing" if lag else "adequate")
    if lag:
        (effect,) = found.effects
        low, high = effect.parameters["time_constant"].interval
        assert low < lag < high
