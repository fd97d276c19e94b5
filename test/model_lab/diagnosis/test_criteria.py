"""Verdicts on made-up fits: errors are stated in units of the noise floor, and so is the answer."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from made_up_fits import Said, beyond, made_up_model, made_up_problem
from scipy.optimize import brentq
from scipy.stats import f as variance_ratio

from model_lab.bench.layouts import hand_pose_set
from model_lab.diagnosis import criteria, diagnose, selection
from model_lab.diagnosis.black_boxes import BlackBox
from model_lab.diagnosis.criteria import (
    beyond_repeats,
    constants_error,
    depends_on,
    is_noise,
    verdict_of,
)
from model_lab.diagnosis.forward_selection import ForwardSelection
from model_lab.diagnosis.selection import Selection
from model_lab.fitting.fit import Scales
from model_lab.fitting.noise_floor import make_spectrum, noise_floor
from model_lab.measurements.measurement_set import MeasurementSet
from model_lab.series.events import group_of_runs
from softhand_model.effects import effect_classes

ADEQUATE, MISSING, UNEXPLAINED = "adequate", "effects_missing", "unexplained"
EXACT = 1e6  # degrees of freedom of repeats that tell the noise to the last digit
FLOOR = 0.5  # in the unit of the outputs
EXCESS = 15.0  # of the model as it is, where effects were named
PLAIN, MEMORY = "pressure", "pressure_rate"  # black boxes: the latter depends on what was before
GENT, CREEP = "gent_stiffening", "viscoelasticity"  # and effects likewise


def black_box(problem, rmse, name=PLAIN):
    return BlackBox(name, np.full(problem.data.table.samples, FLOOR * rmse), 3)


def model(problem, effects, said):
    """The fitted model of which this is said in units of the floor."""
    fitted = None if said.fitted is None else FLOOR * said.fitted
    said = replace(said, shape=FLOOR * said.shape, gain=FLOOR * said.gain, fitted=fitted)
    return made_up_model(problem, effects, said)


def verdict(said, effects=(), base=None, boxes=(), **options):
    """The verdict on a model with these effects added, beside black boxes (error, name)."""
    problem = made_up_problem(level=FLOOR, **options)
    first = model(problem, (), base or said)
    final = model(problem, effects, said) if effects else first
    return verdict_of(problem, first, final, [black_box(problem, *box) for box in boxes])


def border(chance, dof, lost=0.0, folds=6):
    """Error that noise exceeds at this chance in any of the bands, given the degrees of freedom."""
    problem = made_up_problem(folds=folds)
    counts = problem.spectrum.counts()[1:]  # the error is all in the shape
    size = folds * 2 * 100 / counts.sum()  # mean square in these bands of one over all

    def beyond_chance(error):
        ratio = size * error**2 / (1.0 + lost)
        chances = variance_ratio.sf(ratio, counts, dof)
        return np.log(min(chances) * (len(counts) + 1) / chance)

    return brentq(beyond_chance, 0.9, 30.0)


# ---------------------------------------------------------------- a model to which nothing is added
def test_an_error_that_no_output_of_a_hand_tells_alone_is_told_by_all_together():
    data, random = hand_pose_set(), np.random.default_rng(2)
    table, counts = data.table, len(data.table.value) // len(data.runs)
    noise = random.standard_normal(table.samples)
    spectrum = make_spectrum(table, np.ones(table.samples))
    problem = SimpleNamespace(spectrum=spectrum, floor=noise_floor(data, spectrum, noise))
    assert beyond_repeats(problem, noise) > 0.1
    missed = 0.7 * random.standard_normal((len(data.runs), counts))[group_of_runs(data)].ravel()
    assert beyond_repeats(problem, noise + missed) < 1e-3
    outputs = [np.where(table.output == one, noise + missed, noise) for one in range(15)]
    assert min(beyond_repeats(problem, one) for one in outputs) > 0.005


def test_a_model_at_the_floor_is_adequate_though_a_black_box_knows_far_more():
    assert verdict(Said(0.99), boxes=[(0.1,)]) == ADEQUATE


@pytest.mark.parametrize(
    ("rmse", "folds", "answer"),
    [(0.66, 6, UNEXPLAINED), (0.69, 6, ADEQUATE), (0.66, 3, UNEXPLAINED), (0.1, 2, ADEQUATE)],
)
def test_a_black_box_that_is_far_better_shows_that_something_is_missing(rmse, folds, answer):
    """Even within the scatter of repeats, but not where what is held out is extrapolated."""
    assert verdict(Said(1.05), boxes=[(rmse,)], folds=folds, dof=2.0) == answer


@pytest.mark.parametrize(("error", "answer"), [(1.11, ADEQUATE), (1.13, UNEXPLAINED)])
def test_an_error_hardly_above_the_floor_is_adequate_however_surely_it_is_there(error, answer):
    assert verdict(Said(error), dof=EXACT, folds=500) == answer


@pytest.mark.parametrize("dof", [12.0, 40.0])
def test_an_error_must_exceed_the_scatter_of_repeats_beyond_chance(dof):
    # two parameters of twelve runs: what was held out errs by a fifth more
    far = border(5e-3, dof, lost=0.2)
    assert verdict(Said(0.995 * far), dof=dof) == ADEQUATE
    assert verdict(Said(1.005 * far), dof=dof) == UNEXPLAINED


@pytest.mark.parametrize(("error", "answer"), [(3.74, ADEQUATE), (3.76, UNEXPLAINED)])
def test_an_error_far_above_the_floor_is_no_noise_however_few_repeats_there_are(error, answer):
    problem = made_up_problem(level=FLOOR, dof=0.1)
    table = problem.data.table
    large = replace(table, value=10.0 * table.value)  # of which a constant says nothing
    problem = replace(problem, data=SimpleNamespace(**vars(problem.data) | {"table": large}))
    base = model(problem, (), Said(error))
    assert verdict_of(problem, base, base, []) == answer


@pytest.mark.parametrize(
    ("times", "folds", "answer"),
    [(1.01, 6, UNEXPLAINED), (0.99, 6, ADEQUATE), (1.01, 3, UNEXPLAINED), (2.0, 2, ADEQUATE)],
)
def test_a_model_that_predicts_worse_than_a_constant_is_not_adequate(times, folds, answer):
    """However much repeats scatter: as where markers are mixed up from sample to sample."""
    error = times * constants_error(made_up_problem(folds=folds)) / 0.85
    assert verdict(Said(error / FLOOR), dof=1e-3, folds=folds) == answer


def test_a_constant_predicts_its_scatter():
    problem = made_up_problem(folds=5)
    table = problem.data.table
    noise = np.random.default_rng(1).standard_normal(table.samples)
    problem = replace(problem, data=SimpleNamespace(table=replace(table, value=3.0 + noise)))
    assert constants_error(problem) == pytest.approx(1.0, rel=0.05)


def test_bands_in_which_no_repeats_were_seen_tell_nothing():
    assert verdict(Said(3.0), dof=EXACT) == UNEXPLAINED
    problem = made_up_problem(level=FLOOR)
    of_gains = np.array([EXACT] + [0.0] * (problem.spectrum.band_count - 1))
    problem = replace(problem, floor=replace(problem.floor, dof=of_gains))
    base = model(problem, (), Said(3.0))
    assert verdict_of(problem, base, base, []) == ADEQUATE


@pytest.mark.parametrize(("shape", "answer"), [(1.24, ADEQUATE), (1.26, UNEXPLAINED)])
def test_without_repeats_the_gains_of_runs_are_no_fault_of_the_model(shape, answer):
    assert verdict(Said(shape, gain=3.0), gain_known=False) == answer


# ---------------------------------------------------------------- a model with effects added
def explained(said, boxes=(), **options):
    """Whether effects count as the explanation of an excess error of EXCESS floors."""
    options = {"dof": EXACT, **options}
    effects = options.pop("effects", [GENT])
    answer = verdict(said, effects, Said(beyond(EXCESS)), boxes, **options)
    assert answer in (MISSING, UNEXPLAINED)
    return answer == MISSING


def leaves(share, **said):
    return Said(beyond(share * EXCESS), **said)


@pytest.mark.parametrize(("error", "answer"), [(1.29, True), (1.31, False)])
def test_effects_that_lead_near_the_floor_explain_the_error(error, answer):
    # of another form they leave too much: an excess of 1 is nearly all of this one
    problem = {"base": Said(1.5), "dof": EXACT}
    assert (verdict(Said(error), [GENT], **problem) == MISSING) == answer


@pytest.mark.parametrize(
    ("held_out", "answer"), [(3.0, MISSING), (3.7, MISSING), (3.8, UNEXPLAINED), (6.2, UNEXPLAINED)]
)
def test_of_two_folds_what_is_held_out_must_be_predicted_too(held_out, answer):
    """A drift may be fitted to the slip of a clamp in one of two runs."""
    base, said = Said(8.0, fitted=6.0), Said(held_out, fitted=1.2)
    assert verdict(said, [GENT], base, folds=2) == answer


@pytest.mark.parametrize(("further", "answer"), [(1.05, UNEXPLAINED), (1.2, MISSING)])
def test_of_two_folds_one_beyond_the_inputs_of_the_other_need_not_be_predicted(further, answer):
    problem = made_up_problem(level=FLOOR, dof=EXACT, folds=2)
    data, table = problem.data, problem.data.table
    beyond_it = {int(run) for run in np.unique(table.run[table.fold == 1])}
    ramp = further * data.driving(data.runs[0])
    runs = tuple(
        replace(run, columns={**run.columns, "pressure": ramp}) if index in beyond_it else run
        for index, run in enumerate(data.runs)
    )
    problem = replace(problem, data=replace(data, runs=runs))
    base, final = model(problem, (), Said(8.0)), model(problem, [GENT], Said(1.2))
    residual = np.where(table.fold == 1, 8.0 * FLOOR, final.held_out.residual)
    final = replace(final, held_out=replace(final.held_out, residual=residual))
    assert verdict_of(problem, base, final, []) == answer


def test_of_two_folds_effects_must_remove_half_of_what_is_held_out():
    base = Said(5.0, fitted=5.0)
    assert verdict(Said(2.5, fitted=1.2), [GENT], base, folds=2) == MISSING
    assert verdict(Said(2.9, fitted=1.2), [GENT], base, folds=2) == UNEXPLAINED


@pytest.mark.parametrize(("shape", "answer"), [(1.24, True), (1.26, False)])
def test_without_repeats_the_shape_must_come_near_the_floor(shape, answer):
    base = Said(1.3, gain=3.2)
    given = verdict(Said(shape, gain=3.0), [GENT], base, gain_known=False)
    assert (given == MISSING) == answer


def test_gains_of_blocks_of_a_run_are_no_scatter_of_runs():
    problem = made_up_problem(level=FLOOR, gain_known=False)
    final = model(problem, (), Said(1.2, gain=3.0))
    runs = tuple(replace(run, protocol="p") for run in problem.data.runs)
    blocks = replace(problem, data=replace(problem.data, runs=runs))
    assert blocks.data.table.holdout == "blocks"
    assert is_noise(problem, final) and not is_noise(blocks, final)


@pytest.mark.parametrize(("share", "answer"), [(0.34, True), (0.36, False)])
@pytest.mark.parametrize("boxes", [[], [(0.1, MEMORY)]])
def test_effects_of_another_form_may_leave_a_third_of_the_excess(share, answer, boxes):
    base, said = Said(beyond(8.0)), Said(beyond(share * 8.0))
    given = verdict(said, [GENT], base, boxes, dof=EXACT)
    assert (given == MISSING) == answer


def with_gain(whole, shape):
    """A model whose whole error and whose error without gains exceed the floor by these."""
    left = beyond(shape)
    return Said(left, gain=float(np.sqrt(beyond(whole) ** 2 - left**2)))


@pytest.mark.parametrize(
    ("whole", "shape", "answer"), [(0.45, 0.32, True), (0.55, 0.32, False), (0.45, 0.38, False)]
)
def test_effects_of_another_form_may_leave_a_third_of_the_shape_and_half_of_all(
    whole, shape, answer
):
    base, said = with_gain(5.0, 3.5), with_gain(whole * 5.0, shape * 3.5)
    assert (verdict(said, [GENT], base, dof=EXACT) == MISSING) == answer


@pytest.mark.parametrize(
    ("error", "usual", "running", "answer"),
    [
        (2.5, 1.0, True, UNEXPLAINED),
        (1.9, 1.0, True, MISSING),
        (2.5, 9.0, True, MISSING),
        (2.5, 1.0, False, MISSING),
    ],
)
def test_an_effect_at_the_edge_of_its_usual_range_stands_in_for_what_runs_on(
    monkeypatch, error, usual, running, answer
):
    """Much left, the parameter (1) at the end of its usual range, and a residual that runs on."""
    problem = made_up_problem(level=FLOOR, dof=EXACT)
    first, final = (
        model(problem, names, Said(size)) for names, size in (((), 20), ([GENT], error))
    )
    likelihood = final.fit.likelihood
    for place, parameter in enumerate(likelihood.parameters):
        likelihood.parameters[place] = replace(parameter, typical=(0.0, usual))
    likelihood.scales = Scales.of(likelihood.parameters)
    if running:
        course = np.sin(np.arange(problem.data.table.samples) / 8.0)
        residual = FLOOR * error * course / np.sqrt(np.mean(course**2))
        final = replace(final, fit=replace(final.fit, residual=residual))
    assert verdict_of(problem, first, final, []) == answer
    if not running:  # runs of a hand's poses are too short to tell
        monkeypatch.setattr(criteria, "residual_tests", lambda *_: None)
        assert verdict_of(problem, first, final, []) == answer
        monkeypatch.setattr(MeasurementSet, "of_hand", True)
        assert verdict_of(problem, first, final, []) == UNEXPLAINED


@pytest.mark.parametrize(("error", "answer"), [(1.11, True), (1.13, False)])
def test_two_effects_that_reach_the_floor_are_named_though_the_likelihood_misses_it(
    monkeypatch, error, answer
):
    """The likelihood hardly feels the error of whole runs, so the second was not selected."""
    problem = made_up_problem(level=FLOOR, dof=EXACT)
    base, one, two = (
        model(problem, names, Said(size))
        for names, size in (((), 20.0), ((GENT,), 5.0), ((GENT, CREEP), error))
    )
    forward = ForwardSelection(((one,), (two,)), one)
    found = Selection(base, (one,), (), forward, {}, 10.0, ((),))
    monkeypatch.setattr(diagnose, "with_lower_floor", lambda *_: None)
    monkeypatch.setattr(diagnose, "black_boxes_of", lambda *_: ())
    monkeypatch.setattr(selection, "_ties", lambda *_: ((), ()))
    judged = diagnose._judged_search(problem, [], lambda *_: found, lambda *_: None)
    assert judged.verdict == (MISSING if answer else UNEXPLAINED)
    assert judged.added == ([GENT, CREEP] if answer else [])
    assert [scored.added for scored in judged.helping] == ([] if answer else [GENT, CREEP])


@pytest.mark.parametrize(
    ("share", "at_limit", "answer"),
    [(0.19, True, True), (0.21, True, False), (0.21, False, True)],
)
def test_effects_on_their_limits_explain_the_error_only_if_little_is_left(share, at_limit, answer):
    assert explained(leaves(share, at_limit=at_limit)) == answer


@pytest.mark.parametrize(("share", "answer"), [(0.19, True), (0.21, False)])
def test_an_effect_of_a_hand_has_no_other_equation(monkeypatch, share, answer):
    assert explained(leaves(share))
    monkeypatch.setattr(criteria, "HandEffect", effect_classes()[GENT])
    assert explained(leaves(share)) == answer


@pytest.mark.parametrize(
    ("share", "std", "answer"), [(0.3, 0.3, MISSING), (0.3, 0.6, UNEXPLAINED), (0.1, 0.6, MISSING)]
)
def test_the_same_holds_where_the_interval_of_a_parameter_reaches_a_bound(share, std, answer):
    """The parameter is 1, at least 0; Student's factor of so few runs is 2.3."""
    base, said = Said(beyond(8.0)), Said(beyond(share * 8.0), std=std)
    assert verdict(said, [GENT], base, dof=EXACT) == answer


@pytest.mark.parametrize(
    ("effect", "modulus", "answer"),
    [
        ("viscoelasticity", 1.15, MISSING),
        ("creep", 1.15, MISSING),
        ("viscoelasticity", 0.85, UNEXPLAINED),
        ("hysteresis", 1.15, UNEXPLAINED),
        (GENT, 1.15, UNEXPLAINED),
    ],
)
def test_a_modulus_at_its_upper_bound_is_what_relaxes_too_slowly(effect, modulus, answer):
    problem = made_up_problem(level=FLOOR, dof=EXACT)
    base, final = (model(problem, e, Said(beyond(x))) for e, x in (((), 8.0), ((effect,), 2.4)))
    parameters = final.fit.likelihood.parameters
    parameters[0] = replace(parameters[0], name="modulus_scale[A]", low=0.85, high=1.15)
    limits = np.array([True] + [False] * (len(parameters) - 1))
    values = np.array([modulus] + [1.0] * (len(parameters) - 1))
    final = replace(final, fit=replace(final.fit, values=values, at_limit=limits))
    assert verdict_of(problem, base, final, [black_box(problem, 1.2, MEMORY)]) == answer


@pytest.mark.parametrize(("error", "answer"), [(3.7, True), (3.8, False)])
@pytest.mark.parametrize("excess", [20.0, 40.0])
def test_nothing_is_explained_far_above_the_floor(error, answer, excess):
    given = verdict(Said(error), [GENT], Said(beyond(excess)), dof=EXACT)
    assert (given == MISSING) == answer


@pytest.mark.parametrize(
    ("name", "rmse", "answer"),
    [
        ("time_in_run", 1.25, UNEXPLAINED),
        ("run_order", 1.4, UNEXPLAINED),
        ("time_in_run", 2.0, MISSING),
        (PLAIN, 1.25, MISSING),
    ],
)
def test_a_rest_that_goes_with_the_time_of_a_run_or_session_is_another_cause(name, rmse, answer):
    base, said = Said(beyond(8.0)), Said(beyond(0.25 * 8.0))
    assert verdict(said, [GENT], base, [(rmse, name)], dof=EXACT) == answer


# ---------------------------------------------------------------- what the rest depends on
AXES = [SimpleNamespace(against=name) for name in ("time_since_step", "direction", "temperature")]


def rest_of(boxes, failures=(), axes=AXES):
    problem = made_up_problem(level=FLOOR)
    final = model(problem, (), Said(2.0))
    localised = SimpleNamespace(axes=axes, failures=failures)
    found = [black_box(problem, *box) for box in boxes]
    return depends_on(problem.data, final, found, localised)


def test_the_rest_depends_on_what_the_black_boxes_that_know_more_depend_on():
    assert rest_of([(1.0, "pressure_rate"), (1.6, "pressure"), (1.8, "pressure")]) == (
        "pressure_rate",
        "pressure",
    )


@pytest.mark.parametrize(("rmse", "answer"), [(1.69, ("pressure",)), (1.71, ("direction",))])
def test_a_black_box_knows_more_if_it_leaves_an_eighth_less(rmse, answer):
    assert rest_of([(rmse, "pressure")], failures=AXES[1:2]) == answer


def test_axes_that_do_not_vary_in_the_set_are_not_named():
    assert rest_of([(0.5, "temperature"), (1.0, "pressure")]) == ("pressure",)


def test_else_it_depends_on_the_axes_of_failure_three_at_most():
    assert rest_of([], failures=[*AXES, *AXES, SimpleNamespace(against="pressure")]) == (
        "time_since_step",
        "direction",
        "temperature",
    )
    assert rest_of([], failures=[AXES[1], AXES[1]]) == ("direction",)


def test_else_the_axis_that_comes_nearest_is_named():
    assert rest_of([]) == ("time_since_step",)
    assert rest_of([], axes=[]) == ()
