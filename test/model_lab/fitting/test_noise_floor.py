"""The noise floor: from repeats, as stated, from the course; and repeats that are no repeats."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.fft import idct
from scipy.stats import chi2
from toy_forward import toy_forward, toy_set

from model_lab.bench.layouts import hand_pose_set
from model_lab.fitting import noise_floor as module
from model_lab.fitting.noise_floor import REPEATS, SPLINE, STATED, make_spectrum, noise_floor
from model_lab.measurements.measurement_set import OUTPUTS, MeasurementSet, Run, Specimen
from model_lab.measurements.sample_table import Series


def floor_of(data):
    """The floor below the true model."""
    forward = toy_forward(data)
    predicted = forward.predict(np.array([[2.0, 0.5]]))[0]
    spectrum = make_spectrum(data.table, predicted)
    return noise_floor(data, spectrum, forward.measured - predicted)


def test_repeats_tell_the_noise_within_and_between_runs():
    floors = [
        floor_of(toy_set(np.random.default_rng(seed), gain=0.02, noise=0.03)) for seed in range(40)
    ]
    size = np.mean(
        toy_forward(toy_set(np.random.default_rng(0), gain=0.0, noise=0.0)).measured ** 2
    )
    assert {floor.source for floor in floors} == {REPEATS}
    within, between = (
        np.sqrt(np.mean([getattr(floor, part) ** 2 for floor in floors]))
        for part in ("within", "between")
    )
    assert within == pytest.approx(0.03, rel=0.03)
    assert between == pytest.approx(0.02 * np.sqrt(size), rel=0.15)


def test_a_wrong_model_does_not_raise_the_floor():
    data = toy_set(np.random.default_rng(1))
    forward = toy_forward(data)
    right = forward.predict(np.array([[2.0, 0.5]]))[0]
    spectrum = make_spectrum(data.table, right)
    wrong = forward.measured - right + 0.3 * np.sin(4.0 * forward.x)
    assert noise_floor(data, spectrum, wrong).total == pytest.approx(floor_of(data).total, rel=0.02)


def slipped(data, index, step):
    """The set with a step in the middle of one run."""
    run = data.runs[index]
    angle = run.columns["tip_angle"] + step * (np.arange(run.samples) > 50)
    runs = list(data.runs)
    runs[index] = replace(run, columns={**run.columns, "tip_angle": angle})
    return replace(data, runs=tuple(runs))


def test_a_run_in_which_something_slipped_does_not_raise_the_floor():
    data = toy_set(np.random.default_rng(2))
    plain = floor_of(data).total
    assert floor_of(slipped(data, 3, 0.5)).total == pytest.approx(plain, rel=0.25)


def test_runs_that_scatter_alike_are_all_kept():
    kept = 0
    for seed in range(100):
        floor = floor_of(toy_set(np.random.default_rng(seed)))
        kept += int(floor.dof[0] == 6)
    assert kept >= 97


def test_stated_noise_counts_without_repeats():
    data = replace(toy_set(np.random.default_rng(3), repeats=1), noise={"tip_angle": 0.07})
    floor = floor_of(data)
    assert (floor.source, floor.gain_known) == (STATED, False)
    assert floor.total == pytest.approx(0.07)


@pytest.mark.parametrize("kinks", [0, 8])
def test_noise_is_told_from_a_course_with_kinks(kinks):
    data = toy_set(np.random.default_rng(4), repeats=1, noise=0.05)
    bent = [
        replace(
            run,
            columns={
                **run.columns,
                "tip_angle": run.columns["tip_angle"]
                + np.abs((np.arange(run.samples) * kinks / 50.0) % 2.0 - 1.0),
            },
        )
        for run in data.runs
    ]
    floor = floor_of(replace(data, runs=tuple(bent)))
    assert floor.source == SPLINE
    assert floor.total == pytest.approx(0.05, rel=0.35)


# ---------------------------------------------------------------- made-up residuals
def ramps(runs=4, samples=100, protocol=lambda index: index // 2, measured=0.0, **options):
    """A set of runs that measure nothing; those of one protocol are repeats."""
    made = []
    for index in range(runs):
        columns = {"time": np.arange(samples) * 0.1, "pressure": np.linspace(0.0, 1.0, samples)}
        for name in options.get("outputs", ["tip_angle"]):
            columns[name] = np.full(samples, measured)
        made.append(Run(f"r{index}", "s", f"p{protocol(index)}", 293.15, columns))
    experiment = options.get("experiment", "free_bending")
    noise = options.get("noise", {})
    return MeasurementSet(experiment, "ramps", {"s": Specimen("s")}, tuple(made), noise)


def residual_of(coefficients):
    """Residual (samples,) with these coefficients (series, n), for a constant reference."""
    given = np.array(coefficients, float)
    given[:, 0] *= -1.0  # the mirror turns the first vector over
    return idct(given, type=2, norm="ortho", axis=-1).ravel()


def made_up_floor(data, coefficients):
    spectrum = make_spectrum(data.table, np.ones(data.table.samples))
    given = residual_of(coefficients)
    assert spectrum.coefficients(given[None])[0] == pytest.approx(np.ravel(coefficients), abs=1e-9)
    return noise_floor(data, spectrum, given)


def test_bands_reach_to_three_times_the_frequency_of_the_one_before():
    data = ramps()
    spectrum = make_spectrum(data.table, np.ones(400))
    order = spectrum.bands[:100]
    assert np.flatnonzero(np.diff(order)).tolist() == [0, 2, 8, 26, 80]
    assert spectrum.counts().tolist() == [4.0, 8.0, 24.0, 72.0, 216.0, 76.0]
    assert spectrum.in_one_band().counts().tolist() == [400.0]
    assert spectrum.in_one_band().band_count == 1


def test_bands_of_different_outputs_differ():
    data = ramps(outputs=OUTPUTS["base_torque"], experiment="base_torque")
    spectrum = make_spectrum(data.table, np.ones(1200))
    assert spectrum.band_output.tolist() == [0] * 6 + [1] * 6 + [2] * 6
    assert spectrum.in_one_band().band_output.tolist() == [0, 1, 2]
    assert spectrum.in_one_band().counts().tolist() == [400.0] * 3


@pytest.mark.parametrize("scale", [1.0, -1.0, 1e-3])
def test_the_transform_keeps_squares_and_has_the_prediction_as_its_first_vector(scale):
    data, random = ramps(), np.random.default_rng(1)
    reference = np.concatenate([scale * np.linspace(0.1, 2.0, 100), np.zeros(300)])
    spectrum = make_spectrum(data.table, reference)
    residuals = np.stack([3.0 * reference, random.standard_normal(400)])
    found = spectrum.coefficients(residuals)
    assert np.abs(found[0, 0]) == pytest.approx(np.linalg.norm(residuals[0]))
    assert found[0, 1:] == pytest.approx(np.zeros(399), abs=1e-12)
    assert np.sum(found**2, axis=1) == pytest.approx(np.sum(residuals**2, axis=1))
    power = spectrum.power(found)
    assert power[1].sum() == pytest.approx(np.sum(residuals[1] ** 2))
    assert power[0, 0] == pytest.approx(np.sum(residuals[0] ** 2))


@pytest.mark.parametrize("level", [-2.0, 2.0])
def test_a_constant_prediction_of_any_sign_is_a_first_vector_too(level):
    reference = np.full(400, level)
    found = make_spectrum(ramps().table, reference).coefficients(reference[None])[0]
    assert np.abs(found[::100]) == pytest.approx(np.full(4, 20.0))
    assert np.sum(found**2) == pytest.approx(1600.0)


def scattered(shape, gain, groups=2):
    """Coefficients of pairs of repeats that lie so far to both sides of what they share."""
    rows = []
    for group in range(groups):
        apart = np.full(100, shape)
        apart[0] = gain
        shared = np.linspace(5.0, -3.0, 100) + group
        rows += [shared + apart / np.sqrt(2.0), shared - apart / np.sqrt(2.0)]
    return np.array(rows)


@pytest.mark.parametrize("gain", [0.5, 2.0])
def test_the_parts_of_the_floor_are_the_scatter_within_and_between_runs(gain):
    floor = made_up_floor(ramps(4), scattered(0.5, gain))
    assert (floor.source, floor.gain_known) == (REPEATS, True)
    assert floor.variance == pytest.approx([gain**2] + [0.25] * 5)
    assert floor.dof.tolist() == [2.0, 4.0, 12.0, 36.0, 108.0, 38.0]
    assert floor.within == pytest.approx(0.5)
    # squares that cancel leave the root of a rounding error
    assert floor.between == pytest.approx(np.sqrt((gain**2 - 0.25) / 100), abs=1e-7)
    assert floor.total == pytest.approx(np.sqrt((gain**2 + 99 * 0.25) / 100))


def test_errors_that_grow_with_frequency_count_as_alike_over_it():
    rows = scattered(0.5, 0.1)
    floor = made_up_floor(ramps(4), rows)
    pooled = (2 * 0.01 + 198 * 0.25) / 200
    assert floor.variance == pytest.approx(np.full(6, pooled))
    assert floor.between == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize("groups", [2, 3])
def test_the_upper_bound_of_one_level_is_that_of_chi_square(groups):
    floor = made_up_floor(ramps(2 * groups), scattered(0.5, 0.5, groups))
    freedom = 100.0 * groups
    assert floor.upper == pytest.approx(0.5 * np.sqrt(freedom / chi2.ppf(0.05, freedom)))


@pytest.mark.parametrize("groups", [1, 2])
def test_the_upper_bound_of_several_levels_weighs_them_by_their_freedom(groups):
    data = ramps(4, protocol=lambda index: index // 2 if index < 2 * groups else index)
    floor = made_up_floor(data, scattered(0.5, 20.0))
    # share and variance of the gain and of the rest; degrees of freedom of one pair: 1 and 99
    parts = np.array([0.01 * 400.0, 0.99 * 0.25])
    freedom = 2 * parts.sum() ** 2 / (2 * np.sum(parts**2 / (groups * np.array([1.0, 99.0]))))
    expected = parts.sum() * freedom / chi2.ppf(0.05, freedom)
    assert floor.upper == pytest.approx(np.sqrt(expected))


def test_stated_noise_has_the_freedom_of_all_samples_and_each_output_its_own():
    noise = {"torque_x": 0.1, "torque_y": 0.2, "torque_z": 0.4}
    data = ramps(2, protocol=lambda i: i, outputs=noise, experiment="base_torque", noise=noise)
    spectrum = make_spectrum(data.table, np.ones(600))
    floor = noise_floor(data, spectrum, np.full(600, 7.0))
    assert floor.source == STATED
    assert np.sqrt(floor.variance) == pytest.approx(np.repeat([0.1, 0.2, 0.4], 6))
    assert floor.dof.tolist() == [0.0] * 18
    assert floor.total == pytest.approx(np.sqrt((0.01 + 0.04 + 0.16) / 3))
    assert floor.within == pytest.approx(floor.total) and floor.between == 0.0
    one = replace(data, noise=dict.fromkeys(noise, 0.2))
    upper = noise_floor(one, spectrum, np.full(600, 7.0)).upper
    assert upper == pytest.approx(0.2 * np.sqrt(600 / chi2.ppf(0.05, 600)))


def test_noise_that_is_stated_of_some_outputs_alone_does_not_count():
    data = ramps(2, protocol=lambda i: i, outputs=OUTPUTS["base_torque"], experiment="base_torque")
    data = replace(data, noise={"torque_x": 0.1})
    spectrum = make_spectrum(data.table, np.ones(600))
    residual = (
        np.random.default_rng(0).standard_normal(600)
        * np.repeat([1.0, 3.0, 9.0], 100)[np.r_[:300, :300]]
    )
    floor = noise_floor(data, spectrum, residual)
    assert floor.source == SPLINE
    assert np.sqrt(floor.variance[::6]) == pytest.approx([1.0, 3.0, 9.0], rel=0.3)


@pytest.mark.parametrize(("residual", "least"), [(5.0, 5e-9), (0.0, 1e-15)])
def test_a_floor_is_never_nothing(residual, least):
    rows = np.zeros((4, 100))
    rows[:, 0] = 10.0 * residual  # the same in all repeats
    floor = made_up_floor(ramps(), rows)
    assert floor.total == pytest.approx(least)
    stated = ramps(2, protocol=lambda i: i, noise={"tip_angle": 0.0})
    spectrum = make_spectrum(stated.table, np.ones(200))
    assert noise_floor(stated, spectrum, np.full(200, residual)).total == pytest.approx(least)


def test_frequencies_that_no_repeat_has_are_as_quiet_as_the_quietest():
    long, second, other, _ = ramps().runs
    ended = {name: values[:20] for name, values in second.columns.items()}
    data = replace(ramps(), runs=(long, replace(second, columns=ended), other))
    spectrum = make_spectrum(data.table, np.ones(220))
    levels = np.concatenate([[4.0], np.full(2, 3.0), np.full(6, 2.0), np.full(91, 1.0)])
    first, second = residual_of([levels]), residual_of([-levels[:20]])
    floor = noise_floor(data, spectrum, np.concatenate([first, second, np.full(100, 9.0)]))
    assert floor.dof.tolist() == [1.0, 2.0, 6.0, 11.0, 0.0, 0.0]
    assert floor.variance == pytest.approx([32.0, 18.0, 8.0, 2.0, 2.0, 2.0])


@pytest.mark.parametrize(
    ("values", "weights", "expected"),
    [
        ([3.0, 2.0, 2.0, 1.0], [1, 1, 1, 1], [3.0, 2.0, 2.0, 1.0]),
        ([1.0, 2.0, 3.0], [1, 1, 1], [2.0, 2.0, 2.0]),
        ([3.0, 1.0, 2.0], [1, 1, 3], [3.0, 1.75, 1.75]),
        ([2.0, 1.0, 4.0], [1, 1, 2], [2.75, 2.75, 2.75]),
        ([5.0, 1.0, 2.0, 0.0, 6.0], [1, 2, 1, 1, 1], [5.0, 2.0, 2.0, 2.0, 2.0]),
        ([9.0, 1.0, 2.0, 0.5, 0.25], [1, 1, 1, 1, 1], [9.0, 1.5, 1.5, 0.5, 0.25]),
    ],
)
def test_levels_that_rise_are_pooled_by_their_weight_until_none_does(values, weights, expected):
    assert module.falling(np.array(values), np.array(weights, float)) == pytest.approx(expected)


def test_outputs_that_scatter_otherwise_do_not_make_repeats_odd():
    # fingers bend in a plane: markers scatter along x and z by the pressure, along y by nothing
    data, random = hand_pose_set(), np.random.default_rng(4)
    sigma = np.tile([0.5e-3, 1e-6, 0.5e-3], len(data.markers))
    residual = sigma[data.table.output] * random.standard_normal(data.table.samples)
    floor = noise_floor(data, make_spectrum(data.table, np.zeros(data.table.samples)), residual)
    assert floor.total == pytest.approx(np.sqrt(np.mean(sigma**2)), rel=0.1)


def test_the_error_of_the_predictions_is_part_of_the_floor():
    data = toy_set(np.random.default_rng(7), gain=0.0, noise=0.03)
    spectrum = make_spectrum(data.table, np.ones(data.table.samples))
    residual = np.random.default_rng(8).normal(0.0, 0.03, data.table.samples)
    assert noise_floor(data, spectrum, residual, 0.04).total == pytest.approx(0.05, rel=0.05)


# ---------------------------------------------------------------- odd repeats
def kept(levels, dof=60.0):
    levels = np.array(levels, float)
    return module._alike(levels * dof, np.full(len(levels), dof)).tolist()


def test_repeats_that_scatter_far_more_than_the_others_are_left_out():
    assert kept([1.0, 30.0, 1.1, 0.9, 1.0, 1.0]) == [True, False, True, True, True, True]
    # four times the median of the lower half
    assert kept([1.0, 1.0, 1.0, 1.0, 3.9, 30.0]) == [True] * 5 + [False]
    assert kept([1.0, 1.0, 1.0, 1.0, 4.1, 30.0]) == [True] * 4 + [False] * 2
    assert kept([0.5, 0.5, 1.0, 1.0, 1.9, 2.1]) == [True] * 5 + [False]


@pytest.mark.parametrize("levels", [[1.0, 1.0, 30.0], [1.0, 1.2, 0.9, 1.1, 1.0, 1.3]])
def test_few_repeats_and_those_that_scatter_alike_are_kept(levels):
    assert kept(levels) == [True] * len(levels)


def test_one_odd_group_among_many_is_told():
    assert kept([1.0] * 9 + [4.5], dof=400.0) == [True] * 9 + [False]


def test_four_groups_tell_an_odd_one():
    assert kept([1.0, 1.0, 1.0, 30.0]) == [True] * 3 + [False]


def test_what_few_degrees_of_freedom_scatter_by_chance_is_kept():
    assert kept([0.1, 1.0, 1.0, 5.0], dof=2.0) == [True] * 4
    assert module._alike(np.array([1.0, 1.0, 1.0, 99.0]), np.array([9.0, 0.0, 9.0, 9.0])).all()


def test_odd_repeats_show_in_slow_errors_but_not_in_gains_or_noise():
    def dof_of(first, last):
        rows = scattered(0.5, 0.5, groups=5)
        rows[0, first:last] += 8.0
        return made_up_floor(ramps(10), rows).dof[0]

    assert dof_of(1, 27) == 4.0  # one group of five is left out
    assert dof_of(0, 1) == 5.0 and dof_of(27, 100) == 5.0
    assert dof_of(1, 3) == 4.0 and dof_of(9, 27) == 4.0


def test_one_degree_of_freedom_a_group_tells_an_odd_one():
    assert kept([1.0] * 11 + [1e9], dof=1.0) == [True] * 11 + [False]


def test_the_middle_of_an_odd_number_of_groups_is_in_neither_half():
    assert module._ratio_of_halves(np.array([[3.0, 1.0, 2.0]])).tolist() == [3.0]


def test_series_repeat_each_other_in_the_same_place_of_runs_of_one_group():
    series = [
        Series(run, output, group, fold, 0, 1)
        for run, group in ((0, 0), (1, 0), (2, 1))
        for output in (0, 1)
        for fold in (0, 1)
    ]
    found = module._repeated(tuple(series))
    assert [[[(s.run, s.output, s.fold) for s in alike] for alike in block] for block in found] == [
        [[(0, 0, 0), (1, 0, 0)], [(0, 1, 0), (1, 1, 0)]],
        [[(0, 0, 1), (1, 0, 1)], [(0, 1, 1), (1, 1, 1)]],
    ]


# ---------------------------------------------------------------- noise from the course
@pytest.mark.parametrize(
    ("ends", "pieces"),
    [
        ((0, 19), []),
        ((5, 25), [(5, 25)]),
        ((0, 499), [(0, 499)]),
        ((100, 600), [(100, 350), (350, 600)]),
    ],
)
def test_courses_are_cut_into_pieces_that_tell_noise(ends, pieces):
    assert module._pieces(*ends) == pieces


def test_long_courses_are_known_from_a_dozen_pieces_evenly_over_them():
    random = np.random.default_rng(2)
    data = ramps(1, samples=20000)
    noise = 0.1 * random.standard_normal(20000)
    noise[:250] *= 100.0
    spectrum = make_spectrum(data.table, np.ones(20000))
    assert noise_floor(data, spectrum, noise).total == pytest.approx(0.1, rel=0.1)


def stretched(samples, runs, stress=lambda stretch: 0.0 * stretch):
    """A test of rubber without repeats, whose stress [Pa] is a function of the stretch."""
    stretch = np.linspace(1.0, 3.0, samples)
    made = [
        Run(
            f"r{index}",
            "s",
            f"p{index}",
            293.15,
            {"stretch": stretch, "stress": stress(stretch)},
            mode="uniaxial",
        )
        for index in range(runs)
    ]
    return MeasurementSet("rubber", "rubber", {"s": Specimen("s")}, tuple(made))


def test_rubber_without_repeats_may_be_off_by_two_percent_as_a_whole():
    data = stretched(100, 3, stress=lambda stretch: 1e3 * stretch)
    spectrum = make_spectrum(data.table, data.table.value)
    floor = noise_floor(data, spectrum, np.random.default_rng(3).normal(0.0, 2.0, 300))
    assert floor.source == SPLINE and floor.gain_known
    squares = np.sum((1e3 * np.linspace(1.0, 3.0, 100)) ** 2)
    assert floor.variance[0] - floor.variance[1] == pytest.approx(0.02**2 * squares)
    assert floor.variance[1:] == pytest.approx(np.full(len(floor.variance) - 1, 4.0), rel=0.3)


def test_noise_of_a_few_readings_of_rubber_is_what_splines_over_the_stretch_leave():
    found = []
    for seed in range(8):
        data = stretched(20, 4)
        noise = np.random.default_rng(seed).normal(0.0, 2.0, 80)
        spectrum = make_spectrum(data.table, np.tile(np.linspace(1.0, 3.0, 20), 4))
        floor = noise_floor(data, spectrum, noise)
        rests = [module.short_spline_rest(np.linspace(1.0, 3.0, 20), y) for y in np.split(noise, 4)]
        squares, freedom = np.sum(rests, axis=0)
        assert floor.variance[1] == pytest.approx(squares / freedom)
        found.append(floor.within)
    assert np.sqrt(np.mean(np.square(found))) == pytest.approx(2.0, rel=0.08)


def test_a_coarse_sensor_adds_the_error_of_its_rounding_to_what_is_stated():
    step = 0.1
    course = np.linspace(0.0, 8.0, 800)
    columns = {
        "time": 0.1 * np.arange(800),
        "pressure": course * 1e4,
        "tip_angle": step * np.round(course / step),
    }
    runs = (Run("r", "s", "p", 293.15, columns),)
    data = MeasurementSet("free_bending", "set", {"s": Specimen("s")}, runs, {"tip_angle": 0.02})
    spectrum = make_spectrum(data.table, course)
    floor = noise_floor(data, spectrum, data.table.value - course)
    assert floor.source == STATED
    assert floor.total == pytest.approx(np.sqrt(0.02**2 + step**2 / 12), rel=0.1)
