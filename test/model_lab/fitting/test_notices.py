"""What is odd about sets that are made so: each oddity is said, and none where nothing is."""

from dataclasses import replace

import numpy as np
import pytest
from toy_forward import toy_set

from bench.hidden import make_set
from model_lab.comparison.compare import compare
from model_lab.fitting.noise_floor import make_spectrum, noise_floor
from model_lab.fitting.notices import notices
from model_lab.measurements.load import load_measurements
from softhand_model.model_file import load_model

LEVEL = 0.02  # of the noise


def noticed(change=None, data=None, seed=1, stated=None):
    """Notices by kind of a set whose residual is noise and a change(run, time, random)."""
    random = np.random.default_rng(seed)
    data = data or toy_set(random)
    data = replace(data, noise={} if stated is None else {"tip_angle": stated})
    residual = LEVEL * random.standard_normal(data.table.samples)
    for course in data.table.courses if change else ():
        time = data.runs[course.run].columns["time"]
        residual[course.samples] += change(course.run, time, random)
    spectrum = make_spectrum(data.table, data.table.value - residual)
    floor = noise_floor(data, spectrum, residual)
    return {notice.kind: notice for notice in notices(data, floor, residual)}


def hum(run, time, random):
    return 5.0 * LEVEL * np.sin(2.0 * np.pi * 1.37 * time + random.uniform(0.0, 2.0 * np.pi))


@pytest.mark.parametrize("seed", range(8))
def test_noise_is_not_odd(seed):
    assert noticed(seed=seed, stated=LEVEL) == {}


def test_slow_noise_is_no_line():
    def slow(run, time, random):
        return 0.2 * LEVEL * np.cumsum(random.standard_normal(len(time)))

    assert "line" not in noticed(slow)


def test_a_hum_of_another_phase_in_each_run_is_a_line_and_scatters_repeats():
    found = noticed(hum, stated=0.5 * LEVEL)
    assert found["line"].value == pytest.approx(1.37, rel=0.02)
    assert found["line"].size == pytest.approx(5.0 * LEVEL / np.sqrt(2.0), rel=0.25)
    assert found["repeats"].value > 5.0
    assert "1.37 Hz" in found["line"].text and "times the stated noise" in found["repeats"].text


@pytest.mark.parametrize("multiple", [1, 2])
def test_what_the_input_does_itself_is_no_line(multiple):
    data = toy_set(np.random.default_rng(0))
    for run in data.runs:
        run.columns["pressure"] += np.sin(2.0 * np.pi * 1.37 / multiple * run.columns["time"])
    assert "line" not in noticed(hum, data=data)


@pytest.mark.parametrize("off", [0.0, 5.0])
def test_wild_samples_are_counted_and_marked_however_far_off_the_model_is(off):
    def wild(run, time, random):
        return off + np.where(np.arange(len(time)) % 50 == 20, 0.8, 0.0)

    found = noticed(wild)["wild_samples"]
    assert found.value == 24.0 == len(found.marked)
    assert found.size == pytest.approx(0.8, rel=0.1)


def test_readings_of_a_coarse_sensor_that_flicker_are_not_wild():
    """By one step, while the model goes on smoothly and far off."""
    data = toy_set(np.random.default_rng(0))
    flicker = np.random.default_rng(1).random(data.table.samples) < 0.05
    readings = 0.1 * flicker
    runs = [
        replace(run, columns={**run.columns, data.outputs[0]: readings[data.table.run == number]})
        for number, run in enumerate(data.runs)
    ]
    data = replace(data, runs=tuple(runs))
    smooth = 5.0 + 1e-4 * np.arange(data.table.samples)
    spectrum = make_spectrum(data.table, smooth)
    floor = noise_floor(data, spectrum, readings - smooth)
    assert "wild_samples" not in {one.kind for one in notices(data, floor, readings - smooth)}


@pytest.mark.parametrize("factor", [1000.0, 1e-3, 57.3])
def test_readings_of_another_size_than_the_models_are_said(factor):
    """Units that are taken for one another, as Pa for kPa or degrees for radians."""
    data = toy_set(np.random.default_rng(0))
    residual = data.table.value * (1.0 - factor)
    floor = noise_floor(data, make_spectrum(data.table, data.table.value - residual), residual)
    found = {one.kind: one for one in notices(data, floor, residual)}["size"]
    assert found.value == pytest.approx(factor)
    assert "units" in found.text


def test_pressures_that_look_absolute_are_said():
    data = toy_set(np.random.default_rng(0))
    assert "absolute" not in noticed(data=data)
    for run in data.runs:
        run.columns["pressure"] = 101.3e3 + 1e4 * np.abs(run.columns["pressure"])
    assert "gauge pressure" in noticed(data=data)["absolute"].text


@pytest.mark.parametrize("share", [0.5, 1.0, 2.0])
def test_gauge_pressures_like_that_of_the_air_at_which_the_actuator_bends_are_not_absolute(share):
    """Recorded from 90 kPa on, as of a stiff actuator that is never emptied; a bend that grows
    as the square of the pressure is no rest either.
    """
    data = toy_set(np.random.default_rng(0))
    for run in data.runs:
        run.columns["pressure"] = 90e3 + 2e4 * run.columns["pressure"]
        run.columns["tip_angle"] = (run.columns["pressure"] / 1e5) ** share
    assert "absolute" not in noticed(data=data)


@pytest.mark.parametrize(("factor", "other"), [(1e3, "milliseconds"), (1e-3, "seconds")])
def test_times_that_look_like_another_unit_are_said(factor, other):
    data = toy_set(np.random.default_rng(0))
    assert "duration" not in noticed(data=data)
    for run in data.runs:
        run.columns["time"] = factor * run.columns["time"]
    found = noticed(data=data)["duration"]
    assert found.value == pytest.approx(9.9 * factor)
    assert f"times are {other}" in found.text


@pytest.mark.parametrize("factor", [1.0, 1e3, 1e-3])
def test_pulses_whose_integrals_are_of_another_unit_of_time_are_said(factor, tmp_path):
    make_set(tmp_path, "valve_pulse", [], seed=1)
    data = load_measurements(tmp_path)
    for run in data.runs:
        run.columns["duration"] = factor * run.columns["duration"]
    found = [one for one in compare(data, load_model("base")).notices if one.kind == "pulses"]
    assert len(found) == (factor != 1.0)
    if found:
        assert 0.3 < found[0].value * factor <= 1.0
        assert "units of duration and of the integrals" in found[0].text


def test_a_run_of_a_single_sample_is_said_by_its_name():
    data = toy_set(np.random.default_rng(0))
    short = {name: values[:1] for name, values in data.runs[4].columns.items()}
    runs = (*data.runs[:4], replace(data.runs[4], columns=short), *data.runs[5:])
    found = noticed(data=replace(data, runs=runs))["single_sample"]
    assert found.value == 1.0 and found.marked.tolist() == [4]
    assert "r4" in found.text


def test_what_a_model_misses_where_its_input_jumps_is_not_wild():
    """A lag that it lacks makes a spike of the error at every step."""
    data = toy_set(np.random.default_rng(0))
    steps = np.repeat(np.random.default_rng(1).random(data.table.samples // 20), 20)
    late = np.where(np.diff(steps, prepend=steps[0]) != 0.0, np.roll(steps, 1), steps)
    runs = [
        replace(run, columns={**run.columns, "pressure": steps[mine], "tip_angle": late[mine]})
        for run, mine in ((run, data.table.run == number) for number, run in enumerate(data.runs))
    ]
    data = replace(data, runs=tuple(runs))
    residual = late - steps + 1e-3 * np.random.default_rng(2).standard_normal(len(steps))
    floor = noise_floor(data, make_spectrum(data.table, steps), residual)
    assert "wild_samples" not in {one.kind for one in notices(data, floor, residual)}


def test_steps_are_not_wild():
    assert noticed(lambda run, time, random: np.where(time > 5.0, 0.8, 0.0)).keys() <= {"repeats"}


def test_a_drift_over_the_session_is_said_with_its_size():
    found = noticed(lambda run, time, random: 0.05 * run)["drift"]
    assert found.value == pytest.approx(0.55, rel=0.1)


def test_repeats_that_lie_apart_are_said_by_name():
    clean = toy_set(np.random.default_rng(0))
    group = next(group for group in clean.groups() if len(group) > 1)
    found = noticed(lambda run, time, random: 0.5 * (run == group[1]))["apart"]
    names = [clean.runs[run].name for run in group]
    assert found.value == pytest.approx(0.5, abs=3 * LEVEL)
    assert names[1] in found.text and group[1] in found.marked
    assert len(found.marked) == 2


def test_stated_repeats_that_were_driven_otherwise_are_said_and_do_not_count():
    clean = toy_set(np.random.default_rng(0))
    first = clean.runs[0]
    half = {**first.columns, "pressure": 0.5 * first.columns["pressure"]}
    runs = [
        replace(first, name=f"r{n}", columns=half if n > 2 else first.columns) for n in range(6)
    ]
    data = replace(clean, runs=tuple(runs))
    assert data.groups() == [[0, 1, 2], [3, 4, 5]]
    error = 10.0 * LEVEL  # of the model at half the pressure, which is no noise
    found = noticed(lambda run, time, random: error * (run > 2), data=data)
    assert found.keys() == {"driven"}
    assert found["driven"].marked.tolist() == [3, 4, 5]
    assert "r3 of r0" in found["driven"].text


def test_what_is_said_holds_no_points():
    said = noticed(hum)["line"].as_json()
    assert said.keys() == {"kind", "value", "size", "text"}


def test_gaps_in_the_time_column_are_counted_and_their_longest_is_said():
    data = toy_set(np.random.default_rng(0))
    for run in data.runs[:2]:
        run.columns["time"][40:] += 1.5  # beside 0.1 s between samples
    data.runs[0].columns["time"][70:] += 0.7
    found = noticed(data=data)["gaps"]
    assert found.value == pytest.approx(1.6)
    assert found.marked.tolist() == [39, 69]
    assert "3 gaps of up to 1.6 s" in found.text


def test_samples_at_uneven_times_are_no_gaps():
    data = toy_set(np.random.default_rng(0))
    for run in data.runs:
        run.columns["time"][::2] += 0.04
    assert "gaps" not in noticed(data=data)


def swing(run, time, random):
    return 20.0 * LEVEL * np.exp(-time / 3.0) * np.sin(2.0 * np.pi * 1.37 * time)


def test_an_oscillation_that_dies_away_after_a_step_is_a_swing():
    data = toy_set(np.random.default_rng(3))
    stepped = replace(
        data,
        runs=tuple(
            replace(
                run,
                columns={**run.columns, "pressure": 2e4 * (np.arange(run.samples) > 2)},
            )
            for run in data.runs
        ),
    )
    assert "inflate more slowly" in noticed(swing, data=stepped)["line"].text
    assert "inflate more slowly" not in noticed(hum)["line"].text


@pytest.mark.parametrize("clipped", [True, False])
def test_an_input_at_the_limit_of_its_sensor_is_told(clipped):
    data = toy_set(np.random.default_rng(3))
    runs = []
    for run in data.runs:
        pressure = 4e4 * np.sin(np.pi * np.arange(run.samples) / run.samples)
        columns = {**run.columns, "pressure": pressure, "tip_angle": 1e-4 * pressure}
        if clipped:
            columns["pressure"] = np.minimum(pressure, 3e4)
        runs.append(replace(run, columns=columns))
    found = noticed(data=replace(data, runs=tuple(runs)))
    assert ("clipped" in found) is clipped
    if clipped:
        assert found["clipped"].value == len(runs)
        assert "larger range" in found["clipped"].text


@pytest.mark.parametrize("moved", ["zero", "gain", ""])
def test_repeats_that_differ_by_their_zero_are_told(moved):
    random = np.random.default_rng(5)
    data, runs = toy_set(random), []
    for index, run in enumerate(data.runs):
        pressure = 4e4 * np.sin(np.pi * np.arange(run.samples) / run.samples)
        change = LEVEL * random.standard_normal(run.samples)
        change += 10.0 * LEVEL * (index % 2) * {"zero": 1.0, "gain": pressure / 3e4}.get(moved, 0.0)
        angle = 2e-5 * pressure + change
        runs.append(replace(run, columns={**run.columns, "pressure": pressure, "tip_angle": angle}))
    data = replace(data, runs=tuple(runs), noise={})
    residual = data.table.value - 2e-5 * np.concatenate([run.columns["pressure"] for run in runs])
    floor = noise_floor(data, make_spectrum(data.table, data.table.value - residual), residual)
    found = {notice.kind: notice for notice in notices(data, floor, residual)}
    assert ("zero" in found) is (moved == "zero")
    if moved == "zero":
        assert found["zero"].value == pytest.approx(5.0 * LEVEL, rel=0.1)
