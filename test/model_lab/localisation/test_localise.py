"""A failure that was put into a residual is found on its axis, and mere noise on none."""

import time

import numpy as np
import pytest

from model_lab.bench.layouts import hand_pose_set
from model_lab.localisation.axes import Axis, axes_of
from model_lab.localisation.bins import make_bins
from model_lab.localisation.localise import RUN_BLOCKS, RUNS, localise, where_phrase
from model_lab.measurements.hands import MARKER_AXES
from model_lab.measurements.measurement_set import MeasurementSet, Run, Specimen, down_of

NOISE, SCATTER = 0.006, 0.006


def _course(protocol, moment):
    """Triangle, steps or waves of a run of 20 s, up to 44 kPa."""
    if protocol % 3 == 0:
        return 40e3 * np.clip(1.0 - np.abs(moment / 10.0 - 1.0), 0.0, 1.0)
    if protocol % 3 == 1:
        return np.where(moment < 2.0, 0.0, np.where(moment < 12.0, 30e3, 10e3))
    return 22e3 * (1.0 - np.cos(0.2 * np.pi * moment * (1 + protocol)))


def _set(runs=12, samples=200, specimens=("thin", "thick"), warm=(), mount="base_up"):
    moment = np.linspace(0.0, 20.0, samples)
    made = []
    for index in range(runs):
        course = _course(index // (2 * len(specimens)), moment)
        columns = {"time": moment, "pressure": course, "tip_angle": 0.0 * course}
        temperature = 303.15 if index in warm else 293.15
        specimen = specimens[index % len(specimens)]
        protocol = f"p{index // (2 * len(specimens))}"
        made.append(Run(f"r{index}", specimen, protocol, temperature, columns))
    known = {
        name: Specimen(
            name, {"wall": 0.0025 + 0.001 * place}, ("bending_plane_level", mount)[place]
        )
        for place, name in enumerate(specimens)
    }
    return MeasurementSet("free_bending", "", known, tuple(made))


def test_values_that_differ_by_rounding_are_no_axis():
    """On triangles a pressure rests for one sample at each turn: always for 0.05 s."""
    time = np.arange(0.0, 12.0, 0.05)
    pressure = np.interp(time % 6.0, [0.0, 3.0, 6.0], [0.0, 40e3, 0.0])
    columns = {"time": time, "pressure": pressure, "tip_angle": 0.0 * pressure}
    runs = tuple(Run(name, "thin", "ramp", 293.15, columns) for name in ("r1", "r2"))
    thin = Specimen("thin", {"wall": 0.0025}, "bending_plane_level")
    names = [
        axis.name for axis in axes_of(MeasurementSet("free_bending", "", {"thin": thin}, runs))
    ]
    assert "direction" in names and "time_since_step" not in names


def _noise(data, seed):
    """Noise of samples, and of runs as a whole."""
    random = np.random.default_rng(seed)
    return np.concatenate(
        [
            NOISE * random.standard_normal(run.samples)
            + SCATTER * random.standard_normal() * run.columns["pressure"] / 45e3
            for run in data.runs
        ]
    )


def _residual(data, error, seed=0):
    """Noise and an error: a function of run and its index, [rad] (samples,)."""
    parts = [error(run, index) * np.ones(run.samples) for index, run in enumerate(data.runs)]
    return _noise(data, seed) + np.concatenate(parts)


def _found(data, error):
    localisation = localise(data, _residual(data, error))
    return {axis.against: axis for axis in localisation.failures}


def test_an_error_above_a_pressure_is_found_there():
    found = _found(_set(), lambda run, _: 0.03 * (run.columns["pressure"] > 25e3))
    first = next(iter(found.values()))
    assert first.against == "pressure"
    words = first.where.split()
    assert words[0] == "above"
    assert words[2] == "kPa"
    assert 20.0 < float(words[1]) < 31.0
    assert first.p_value <= 0.002
    assert first.share_of_error > 0.5
    assert first.basis == RUNS


def test_the_share_of_error_is_that_of_the_planted_dependence():
    data = _set()
    pressure = np.concatenate([run.columns["pressure"] for run in data.runs])
    error = 0.02 * np.where(pressure > 20e3, 1.0, -1.0)
    residual = error + 0.02 * np.random.default_rng(0).standard_normal(len(error))
    by_name = {axis.against: axis for axis in localise(data, residual).axes}
    planted = np.var(error) / np.mean(residual**2)
    assert by_name["pressure"].share_of_error == pytest.approx(planted, abs=0.04)


def test_an_error_at_a_temperature_is_found_there():
    data = _set(warm=(2, 5, 6, 11))
    found = _found(data, lambda run, _: 0.03 * (run.temperature > 300.0))
    assert next(iter(found)) == "temperature"
    assert found["temperature"].where == "above 25 degC"
    assert "specimen" not in found


def test_an_error_of_one_specimen_is_found_there():
    found = _found(_set(), lambda run, _: 0.03 * (run.specimen == "thick"))
    assert {"specimen", "wall", "mount"} == set(found)
    assert found["specimen"].where == "specimen thick"
    assert found["wall"].where == "wall above 3 mm"
    assert found["mount"].where == "mounted base up"


def test_an_error_while_pressure_falls_is_found_there():
    def error(run, _):
        falls = np.gradient(run.columns["pressure"]) < -10.0
        return 0.02 * falls

    found = _found(_set(), error)
    assert found["direction"].where == "while pressure falls"
    assert found["pressure_rate"].where.startswith("below -")


def test_creep_after_a_step_is_found_against_time():
    def error(run, index):
        moment = run.columns["time"]
        return 0.03 * np.exp(-np.abs(moment - 3.0)) * (moment > 2.0) * (4 <= index < 8)

    found = _found(_set(), error)
    assert found["time_since_step"].where.startswith("within ")
    assert found["time_since_step"].where.endswith(" s of a step")


def test_an_error_in_first_runs_is_found_there():
    data = _set(24, specimens=("thin", "thick"))
    found = _found(data, lambda _, index: 0.03 * (index < 2))
    assert found["run_order"].where == "first run of each specimen"


def test_noise_is_blamed_on_nothing():
    data = _set(warm=(2, 5, 6, 11))
    blamed = [len(localise(data, _noise(data, 100 + seed)).failures) > 0 for seed in range(60)]
    assert np.mean(blamed) < 0.17  # at most 5 % of sets by design: seven of 60 have p = 0.02


def test_p_values_of_noise_are_even():
    data = _set(warm=(2, 5, 6, 11))
    results = [localise(data, _noise(data, 200 + seed), seed) for seed in range(60)]
    for name in ("pressure", "direction", "temperature"):
        values = [axis.p_value for one in results for axis in one.axes if axis.against == name]
        assert 0.3 < np.mean(values) < 0.7
        assert np.mean(np.array(values) < 0.1) < 0.25


def test_the_band_holds_the_true_mean():
    data = _set(24)
    inside, total = 0, 0
    for seed in range(20):
        pressure = localise(data, _noise(data, seed)).axes
        curve = next(axis for axis in pressure if axis.against == "pressure").curves["tip_angle"]
        inside += np.sum((curve.low <= 0.0) & (curve.high >= 0.0))
        total += len(curve.mean)
    assert 0.85 < inside / total <= 1.0


def test_curves_are_the_means_in_the_bins():
    data = _set(warm=(0, 1))
    residual = _noise(data, 3)
    by_name = {axis.against: axis for axis in localise(data, residual).axes}
    warm = np.concatenate([np.full(run.samples, run.temperature > 300.0) for run in data.runs])
    curve = by_name["temperature"].curves["tip_angle"]
    np.testing.assert_allclose(curve.mean, [residual[~warm].mean(), residual[warm].mean()])
    np.testing.assert_array_equal(curve.count, [2000, 400])


def test_the_same_seed_gives_the_same_answer():
    data = _set()
    residual = _noise(data, 5)
    first, again = (localise(data, residual, 7) for _ in range(2))
    assert [(a.against, a.p_value) for a in first.axes] == [
        (a.against, a.p_value) for a in again.axes
    ]


def test_few_runs_are_cut_into_blocks_and_it_is_said():
    data = _set(1, 2000, ("thin",))
    localisation = localise(data, _residual(data, lambda run, _: 1e-6 * run.columns["pressure"]))
    pressure = localisation.axes[0]
    assert pressure.against == "pressure"
    assert pressure.basis == RUN_BLOCKS
    assert pressure in localisation.failures
    assert {axis.against for axis in localisation.axes}.isdisjoint(
        {"specimen", "wall", "run_order"}
    )


def test_a_constant_error_is_told_apart():
    data = _set()
    localisation = localise(data, 0.1 + _noise(data, 0))
    assert localisation.constant > 0.95
    assert not localisation.failures


def test_every_output_has_its_curve():
    base = _set(12)
    torques = {f"torque_{axis}": np.zeros(200) for axis in "xyz"}
    runs = tuple(
        Run(r.name, r.specimen, r.protocol, r.temperature, {**r.columns, **torques})
        for r in base.runs
    )
    data = MeasurementSet("base_torque", "", base.specimens, runs)
    parts = []
    for run in runs:
        parts += [0.0 * run.columns["pressure"], run.columns["pressure"] - 15e3, np.zeros(200)]
    residual = np.concatenate(parts)
    pressure = localise(data, residual).axes[0]
    assert pressure.against == "pressure"
    assert np.abs(pressure.curves["torque_x"].mean).max() == 0.0
    assert np.ptp(pressure.curves["torque_y"].mean) > 20e3
    assert pressure.share_of_error > 0.8


def test_stretch_and_pressure_drop_stand_for_pressure():
    random = np.random.default_rng(0)
    count = 400
    columns = {
        "direction": np.repeat([1.0, -1.0], count // 2),
        "duration": random.uniform(0.02, 0.2, count),
        "p_in": random.uniform(3e5, 4e5, count),
        "p_out": random.uniform(1e5, 2e5, count),
        "mass": np.zeros(count),
    }
    run = Run("r", "v", "p", 293.15, columns)
    data = MeasurementSet("valve_pulse", "", {"v": Specimen("v")}, (run,))
    residual = 1e-7 * random.standard_normal(count) + 1e-6 * (columns["duration"] < 0.06)
    found = {axis.against: axis for axis in localise(data, residual).axes}
    assert set(found) == {"pressure", "direction", "time_since_step"}
    assert found["pressure"].bins.axis.noun == "pressure drop"
    assert found["time_since_step"].where.startswith("pulse duration below 0.0")
    deflating = localise(data, residual + 1e-5 * (columns["direction"] < 0.0)).axes[0]
    assert deflating.where == "while deflating"


def test_a_residual_of_another_length_is_refused():
    with pytest.raises(ValueError, match=r"residual: expected shape \(2400,\), got \(7,\)"):
        localise(_set(), np.zeros(7))


def test_a_million_samples_take_seconds():
    data = _set(36, 28_000, warm=(3, 4))
    residual = _noise(data, 0)
    start = time.process_time()
    localise(data, residual)
    assert time.process_time() - start < 6.0


@pytest.mark.parametrize("runs", (4, 6, 12, 20))
def test_zeros_that_scatter_from_run_to_run_are_no_certain_failure(runs):
    data = _set(runs, samples=60)
    told = []
    for seed in range(30):
        zeros = 0.02 * np.random.default_rng(seed).standard_normal(runs)
        residual = _residual(data, lambda run, index, zeros=zeros: zeros[index], seed)
        told.append(localise(data, residual, seed).certain_failures)
    assert sum(map(bool, told)) <= 1


def test_an_error_that_grows_with_the_pressure_in_every_run_is_a_certain_failure():
    data = _set(16)
    residual = _residual(data, lambda run, _: 1e-6 * (run.columns["pressure"] - 2e4))
    assert "pressure" in [axis.against for axis in localise(data, residual).certain_failures]


def test_of_a_hand_it_says_which_marker_which_channel_and_which_way_the_weight_pulls():
    data, random = hand_pose_set(), np.random.default_rng(3)
    table = data.table
    noise = 5e-4 * random.standard_normal(table.samples)
    assert localise(data, noise).failures == ()
    marker = [*data.markers].index("ring_tip")
    mine = table.output // len(MARKER_AXES) == marker
    loud = localise(data, noise * np.where(mine, 4.0, 1.0)).failures
    assert [(one.against, one.where) for one in loud] == [("marker", "marker ring_tip")]
    with_pressure = noise + 2e-3 * (data.column("pressure.b") > 15e3) * (table.output == 3)
    of_channel = {one.against: one.where for one in localise(data, with_pressure).failures}
    assert of_channel["pressure.b"].startswith("pressure.b above")
    along = np.array([down_of(run)[1] for run in data.runs])[table.run]
    of_weight = localise(data, noise + 2e-3 * along * (table.output == 3)).axes
    assert "down.y" in [one.against for one in of_weight[:2]]


def test_on_an_axis_of_one_bin_the_error_lies_everywhere():
    values = np.full(4, 1e5)
    bins = make_bins(Axis("pressure", "pressure", "Pa", values))
    assert bins.count == 1
    assert where_phrase(bins, np.array([1.0]), np.array([len(values)])) == "everywhere"
