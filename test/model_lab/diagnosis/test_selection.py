"""What candidates achieve in noise, and which of them are named, from made-up fits: their errors
are stated in units of the noise floor, and so is the answer.
"""

from dataclasses import replace
from itertools import combinations
from types import SimpleNamespace

import made_up_fits
import numpy as np
import pytest
from made_up_fits import (
    Landscape,
    Said,
    beyond,
    made_up_model,
    made_up_problem,
    signature_of,
)
from scipy.stats import chi2, kstest
from toy_forward import toy_forward, toy_set

from model_lab.diagnosis import forward_selection as growing
from model_lab.diagnosis import selection as module
from model_lab.diagnosis.criteria import error_of, excess, material, shape_error, share_left
from model_lab.diagnosis.error_by_step import path
from model_lab.diagnosis.search import Signature
from model_lab.diagnosis.selection import (
    detectable_effects,
    finer_forms,
    null_maxima,
    p_value,
    select,
)
from model_lab.fitting.noise_floor import make_spectrum
from softhand_model.effects import effect_classes
from softhand_model.effects.hand import at_places
from softhand_model.hand.hand import load_hand

EXCESS = 5.0  # of the model as it is


def test_chances_of_the_best_of_several_candidates_are_even_in_noise():
    data = toy_set(np.random.default_rng(0))
    spectrum = make_spectrum(data.table, toy_forward(data).measured)
    random = np.random.default_rng(1)
    samples = spectrum.table.samples
    shapes = random.standard_normal((5, samples)).cumsum(axis=1)
    shapes /= np.linalg.norm(shapes, axis=1, keepdims=True)
    one = np.ones(5)
    found = Signature(one[:, None], np.zeros((2, 1)), shapes, one, one)
    maxima = null_maxima([found], spectrum, seed=2)
    chances = []
    counts = spectrum.counts()
    for _ in range(400):
        noise = random.standard_normal(samples)
        level = np.bincount(spectrum.bands, noise**2) / counts  # known from the noise alone
        whitened = noise / np.sqrt(level[spectrum.bands])
        chances.append(p_value(maxima, float(np.max((shapes @ whitened) ** 2))))
    assert kstest(chances, "uniform").pvalue > 1e-3
    assert np.mean(np.array(chances) < 0.05) < 0.085  # 0.05 and three standard errors


def test_a_candidate_that_changes_nothing_achieves_nothing():
    data = toy_set(np.random.default_rng(0))
    spectrum = make_spectrum(data.table, toy_forward(data).measured)
    none = np.zeros(1)
    idle = Signature(none[:, None], np.zeros((2, 1)), np.zeros((1, 1200)), none, none)
    assert np.all(null_maxima([idle], spectrum, seed=0) == 0.0)


@pytest.mark.parametrize(
    ("improvement", "chance"), [(0.0, 1.0), (1.0, 1.0), (50.5, 0.5), (99.0, 0.02), (1e9, 0.01)]
)
def test_a_chance_is_the_share_of_noise_sets_that_do_as_well_and_never_zero(improvement, chance):
    assert p_value(np.arange(1.0, 100.0), improvement) == pytest.approx(chance)


def test_the_draws_are_the_same_again_and_do_not_depend_on_the_size_of_a_signature():
    problem = made_up_problem()
    one = signature_of(problem, 1)
    drawn = null_maxima([one], problem.spectrum, seed=3)
    assert len(drawn) == 2000 and np.all(np.diff(drawn) >= 0.0)
    assert np.array_equal(drawn, null_maxima([one], problem.spectrum, seed=3))
    assert not np.array_equal(drawn, null_maxima([one], problem.spectrum, seed=4))
    larger = signature_of(problem, 1, strengths=(7.0,))
    assert null_maxima([larger], problem.spectrum, seed=3) == pytest.approx(drawn)
    idle = replace(one, size=np.zeros(1))
    assert null_maxima([idle, one], problem.spectrum, seed=3) == pytest.approx(drawn)
    # of one direction in many samples: chi square of one degree of freedom, a little wider
    assert np.quantile(drawn, 0.9) == pytest.approx(chi2.ppf(0.9, 1), rel=0.15)


def test_noise_whose_level_few_coefficients_tell_is_drawn_wider():
    problem = made_up_problem(folds=2)
    first = signature_of(problem, 1)
    change = np.zeros_like(first.change)
    change[0, 0] = 1.0  # the gain of one of four runs
    drawn = null_maxima([replace(first, change=change)], problem.spectrum, seed=0)
    # normal over the root of chi square over four runs and as many of the floor's
    # pseudo-observations: Student's t, squared
    assert np.quantile(drawn, 0.9) == pytest.approx(1.860**2, rel=0.15)


# ---------------------------------------------------------------- what is named
@pytest.fixture
def choose(monkeypatch):
    """The selection among made-up models, one letter an effect; "" is the model as it is."""

    def choose(models, effects=None, problem=None, given=()):
        problem = problem or made_up_problem()
        landscape = Landscape(problem, models)
        monkeypatch.setattr(module, "score_base", landscape.base)
        monkeypatch.setattr(module, "score_all", landscape.all)
        monkeypatch.setattr(module, "score_without", landscape.without)
        monkeypatch.setattr(growing, "score_without", landscape.without)
        names = effects or sorted({name for name in models if len(name) == 1})
        return select(problem, list(names), list(given), seed=0, jobs=1), landscape

    return choose


def named(choose, models, **options):
    """Letters of the effects that are named."""
    return "".join(choose(models, **options)[0].final.effects)


def leaves(share, deviance=500.0, **said):
    """A model that leaves this share of the excess error."""
    return Said(beyond(share * EXCESS), deviance, **said)


BASE = Said(beyond(EXCESS), 1000.0)


@pytest.mark.parametrize(
    ("share", "answer"), [(0.0, "a"), (0.49, "a"), (0.51, ""), (0.9, ""), (0.98, "")]
)
def test_an_effect_is_named_if_it_removes_half_of_the_excess_error(choose, share, answer):
    assert named(choose, {"": BASE, "a": leaves(share)}) == answer


def test_of_two_that_explain_as_much_the_one_in_its_usual_range_is_named(choose, monkeypatch):
    models = {"": BASE, "a": leaves(0.0, 500.0), "b": leaves(0.0, 505.0)}
    assert choose(models)[0].final.effects == ("a",)
    made = Landscape._one

    def unusual(landscape, before, effect):
        scored = made(landscape, before, effect)
        return replace(scored, unusual=6.0) if effect == "a" else scored

    monkeypatch.setattr(Landscape, "_one", unusual)
    chosen = choose(models)[0]
    assert chosen.final.effects == ("b",) and chosen.ties == (("a",),)


@pytest.mark.parametrize(("error", "answer"), [(1.11, ""), (1.13, "a")])
def test_nothing_is_named_where_the_error_is_hardly_above_the_floor(choose, error, answer):
    assert named(choose, {"": Said(error, 1000.0), "a": Said(1.0, 500.0)}) == answer


@pytest.mark.parametrize(
    ("shape", "gain", "answer"), [(1.2, 3.0, "a"), (1.4, 3.0, ""), (1.4, 2.0, "a")]
)
def test_what_lowers_neither_the_error_nor_that_of_its_shape_is_not_missing(
    choose, shape, gain, answer
):
    """However sure it is: runs that scatter in gain hide the one, noise hides the other."""
    models = {"": Said(1.5, 1000.0, gain=3.0), "a": Said(shape, 500.0, gain=gain)}
    assert named(choose, models, problem=made_up_problem(level=1.39)) == answer


@pytest.mark.parametrize(("gained", "answer"), [(5.0, ""), (9.0, "a")])
def test_an_effect_must_bring_more_than_noise_does(choose, gained, answer):
    # of one direction 6.6 in one set of a hundred
    assert named(choose, {"": BASE, "a": leaves(0.1, 1000.0 - gained)}) == answer


def test_the_threshold_is_what_one_set_of_noise_in_a_hundred_reaches(choose):
    chosen, _ = choose({"": BASE, "a": leaves(0.1)})
    assert chosen.threshold == pytest.approx(chi2.ppf(0.99, 1), rel=0.15)
    many = {letter: leaves(0.9) for letter in "abcdefghijklmnopqrst"}
    assert choose({"": BASE, **many})[0].threshold == pytest.approx(
        chi2.ppf(0.99 ** (1 / 20), 1), rel=0.15
    )


def test_the_chance_of_each_effect_is_stated(choose):
    chosen, _ = choose({"": BASE, "a": leaves(0.1), "b": leaves(0.9, 999.0)})
    assert chosen.p_values["a"] == pytest.approx(1 / 2001)
    assert 0.2 < chosen.p_values["b"] < 0.8


@pytest.mark.parametrize("flaw", [{"known": False}, {"at_limit": True}])
def test_an_effect_whose_parameters_mean_nothing_is_not_named(choose, flaw):
    models = {"": BASE, "a": leaves(0.0, **flaw), "b": leaves(0.2, 600.0)}
    chosen, _ = choose(models)
    assert chosen.final.effects == ("b",)
    assert [scored.added for scored in chosen.proven] == ["b"]


def test_effects_that_cannot_be_seen_are_told_and_the_others_come_best_first(choose):
    models = {"": BASE, "a": leaves(0.9, 900.0), "b": leaves(0.1, 400.0)}
    chosen, _ = choose(models, effects="abc")
    assert [scored.added for scored in chosen.singles] == ["b", "a"]
    assert [unseen.name for unseen in chosen.unseen] == ["c"]
    assert chosen.final.effects == ("b",)


@pytest.mark.parametrize(("ahead", "answer"), [(2.0, "b"), (4.0, "a")])
def test_a_parameter_more_must_bring_its_penalty(choose, ahead, answer):
    """3 of deviance for each."""
    models = {
        "": BASE,
        "a": leaves(0.1, 500.0 - ahead, more_parameters=1),
        "b": leaves(0.1, 500.0),
    }
    assert named(choose, models) == answer


def test_effects_of_the_model_file_stay_in_it(choose):
    models = {"g": BASE, "ga": leaves(0.1)}
    chosen, _ = choose(models, effects="a", given="g")
    assert chosen.base.effects == ("g",)
    assert chosen.final.effects == ("g", "a")


# ---------------------------------------------------------------- pairs
def pairs(left_by_pair, left_by_b=0.9, pair_deviance=100.0):
    return {
        "": BASE,
        "a": leaves(0.4, 500.0),
        "b": leaves(left_by_b, 800.0),
        "ab": leaves(left_by_pair, pair_deviance),
    }


@pytest.mark.parametrize(("left", "answer"), [(0.0, "ab"), (0.19, "ab"), (0.21, "a"), (0.35, "a")])
def test_a_pair_is_named_if_it_removes_more_than_half_of_what_the_best_leaves(choose, left, answer):
    assert named(choose, pairs(left)) == answer


@pytest.mark.parametrize(("gained", "answer"), [(5.0, "a"), (15.0, "ab")])
def test_a_pair_must_bring_more_than_noise_does(choose, gained, answer):
    assert named(choose, pairs(0.1, pair_deviance=500.0 - gained)) == answer


@pytest.mark.parametrize(("left_by_b", "answer"), [(0.15, "b"), (0.25, "ab")])
def test_an_effect_that_removes_little_beside_the_other_is_dropped(choose, left_by_b, answer):
    assert named(choose, pairs(0.1, left_by_b)) == answer


def test_no_pair_is_tried_where_one_effect_reaches_the_floor(choose):
    models = {"": BASE, "a": Said(1.1, 500.0), "b": leaves(0.9, 800.0), "ab": Said(1.0, 100.0)}
    chosen, landscape = choose(models)
    assert chosen.final.effects == ("a",)
    assert landscape.tried == ["a", "b"]


def test_pairs_are_tried_with_the_best_effects_that_bring_a_fifth_of_the_best(choose):
    singles = {"a": 500.0, "b": 510.0, "c": 520.0, "d": 530.0}
    models = {"": BASE, **{name: leaves(0.8, deviance) for name, deviance in singles.items()}}
    _, landscape = choose(models)
    begun = {pair[0] for pair in landscape.tried if len(pair) == 2}
    assert begun == {"a", "b", "c"}
    del models["d"]
    models["b"], models["c"] = leaves(0.8, 890.0), leaves(0.8, 910.0)
    _, landscape = choose(models)
    begun = {pair[0] for pair in landscape.tried if len(pair) == 2}
    assert begun == {"a", "b"}


def test_five_second_effects_are_fitted_to_each(choose):
    models = {"": BASE, "a": leaves(0.8, 500.0), **{n: leaves(0.9, 999.0) for n in "bcdefgh"}}
    _, landscape = choose(models)
    assert len([pair for pair in landscape.tried if len(pair) == 2]) == 5


def test_the_search_for_pairs_ends_with_the_first_that_reaches_the_floor(choose):
    _, landscape = choose(pairs(0.0))
    assert "ab" in landscape.tried and "ba" not in landscape.tried
    _, landscape = choose(pairs(0.35))
    assert "ba" in landscape.tried


def test_a_pair_stands_in_where_no_effect_alone_removes_half(choose):
    models = {**pairs(0.0), "a": leaves(0.8, 500.0)}
    assert named(choose, models) == "ab"


def test_pairs_whose_parameters_mean_nothing_are_not_named(choose):
    models = {**pairs(0.0), "ab": leaves(0.0, 100.0, known=False)}
    assert named(choose, models) == "a"


def test_of_models_of_a_size_the_likeliest_stands_in_for_one_at_the_floor_that_is_not_likelier(
    choose,
):
    """Than one effect less."""
    models = pairs(0.18) | {"c": leaves(0.9, 900.0), "bc": leaves(0.0, 505.0)}
    assert named(choose, models) == "ab"


@pytest.mark.parametrize(("deviance", "answer"), [(450.0, "a"), (350.0, "bcd")])
def test_more_effects_must_be_likelier_than_any_fewer(choose, deviance, answer):
    """Though they are likelier by far than those from which they were tried."""
    models = together("bcd", deviance=deviance)
    chosen = named(choose, models | {"a": leaves(0.45, 400.0)}, problem=made_up_problem(dof=1e6))
    assert chosen == answer


# ---------------------------------------------------------------- three and four
def together(names, left_by_all=0.0, deviance=100.0):
    """Models of effects that share the squared error evenly, and the likelihood too."""
    models, count = {}, len(names)
    for size in range(count + 1):
        for some in combinations(names, size):
            share = np.sqrt(1.0 - (1.0 - left_by_all**2) * size / count)
            fall = (1000.0 - deviance) * size / count + order(some)
            models["".join(some)] = Said(beyond(share * EXCESS), 1000.0 - fall)
    return models


def order(names):
    """A little likelihood more for names that come early."""
    return sum(2.0 - 0.1 * "abcd".index(name) for name in names) if len(names) < 4 else 0.0


@pytest.mark.parametrize("names", ["ab", "abc", "abcd"])
def test_up_to_four_effects_are_named_though_the_first_ones_take_little(choose, names):
    assert named(choose, together(names)) == names


def test_a_fifth_effect_is_not_sought(choose):
    models = {**together("abcd", left_by_all=0.4), "e": leaves(0.9, 900.0)}
    chosen, _ = choose(models)
    assert max(len(s.effects) for models in chosen.forward.sizes for s in models) == 4


@pytest.mark.parametrize(("left", "answer"), [(0.1, "abc"), (0.4, "")])
def test_three_effects_must_explain_the_whole(choose, left, answer):
    problem = made_up_problem(dof=1e6)
    assert named(choose, together("abc", left), problem=problem) == answer


def test_a_third_effect_is_not_sought_for_a_small_rest(choose):
    models = {**pairs(0.19, 0.9), "c": leaves(0.9, 900.0), "abc": leaves(0.0, 50.0)}
    assert named(choose, models) == "ab"


def test_a_third_effect_is_not_sought_where_two_bring_nearly_nothing(choose):
    models = {"": BASE, **{n: leaves(0.95, 900.0) for n in "abc"}}
    models |= {n: leaves(0.92, 800.0) for n in ("ab", "ac", "bc")}
    _, landscape = choose(models)
    assert max(map(len, landscape.tried)) == 2


@pytest.mark.parametrize(("left", "answer"), [(0.0, "abc"), (0.04, "abc"), (0.09, "ab")])
def test_a_third_effect_is_sought_where_two_leave_many_floors(choose, left, answer):
    """Though that is a small part of the error; it is named if all three lead near the floor."""
    excess = 40.0
    shares = {"": 1.0, "a": 0.6, "b": 0.7, "c": 0.9, "ab": 0.15, "ac": 0.6, "bc": 0.7, "abc": left}
    models = {
        name: Said(beyond(share * excess), 500.0 + 900.0 * share) for name, share in shares.items()
    }
    chosen, landscape = choose(models, problem=made_up_problem(dof=1e6))
    assert max(map(len, landscape.tried)) == 3
    assert "".join(chosen.final.effects) == answer


def test_of_models_of_a_size_those_that_reach_the_floor_come_first(choose):
    """Though another has more likelihood and leaves as much error as two effects do."""
    models = {**together("abc"), "d": leaves(0.9, 990.0), "abd": leaves(0.55, 60.0)}
    assert named(choose, models) == "abc"


def test_the_error_falls_effect_by_effect_in_the_order_of_finding(choose):
    chosen, _ = choose(together("abc"))
    models = path(made_up_problem(), chosen.base, chosen.forward, chosen.final)
    assert [scored.effects for scored in models] == [(), ("a",), ("a", "b"), ("a", "b", "c")]
    errors = [scored.held_out.rmse for scored in models]
    assert errors == sorted(errors, reverse=True)


# ---------------------------------------------------------------- ties
TWO = {"b": leaves(0.1, 500.5), "c": leaves(0.1, 500.6)}  # that are tied in any case


def behind_two(choose, base, behind):
    """What is tied with the best of a model, two near ones and one so far behind."""
    models = {"": Said(beyond(EXCESS), base), "a": leaves(0.1), **TWO}
    return choose(models | {"d": leaves(0.1, 500.0 + behind)})[0].ties[0]


@pytest.mark.parametrize(("behind", "tied"), [(7.9, "bcd"), (8.1, "bc")])
def test_an_effect_that_does_nearly_as_well_is_tied(choose, behind, tied):
    assert behind_two(choose, 800.0, behind) == tuple(tied)
    chosen = choose({"": BASE, "a": leaves(0.1), "b": leaves(0.1, 498.0)})[0]
    assert chosen.final.effects == ("b",) and chosen.ties == (("a",),)


def test_of_a_class_of_causes_the_tied_member_of_the_least_error_is_named(choose):
    """Likelihood prefers one member by little, the held-out error another; a third, as good, is of
    another class.
    """
    models = {"": BASE, "a": leaves(0.1), "b": leaves(0.05, 503.0), "c": leaves(0.0, 503.0)}
    problem = made_up_problem()
    lag = {"cause": "lag"}
    lags = {one: SimpleNamespace(**vars(problem.classes[one]) | lag) for one in "ab"}
    alike = replace(problem, classes={**problem.classes, **lags})
    assert choose(models)[0].final.effects == ("a",)
    chosen = choose(models, problem=alike)[0]
    assert chosen.final.effects == ("b",) and set(chosen.ties[0]) == {"a", "c"}


@pytest.mark.parametrize(
    ("left_by_b", "parameters", "answer"), [(0.1, 1, "b"), (0.1, 3, "a"), (0.8, 1, "a")]
)
def test_an_empirical_effect_gives_way_to_one_that_says_why_as_well(
    choose, monkeypatch, left_by_b, parameters, answer
):
    """With no more parameters, and no clearly larger error."""
    monkeypatch.setattr(module, "EMPIRICAL", {"a", "c"})
    problem = made_up_problem()
    counts = {"a": 2, "b": parameters, "c": 1}
    some, plain = {}, SimpleNamespace(name="x", unit="", neutral=0.0)
    for one, count in counts.items():
        more = {"parameters": (plain,) * count}
        some[one] = SimpleNamespace(**vars(problem.classes[one]) | more)
    models = {"": BASE, "a": leaves(0.1), "b": leaves(left_by_b, 503.0), "c": leaves(0.1, 502.0)}
    problem = replace(problem, classes={**problem.classes, **some})
    chosen = choose(models, problem=problem)[0]
    assert chosen.final.effects == (answer,)


def test_nothing_is_tied_whose_error_is_many_times_larger(choose):
    """Errors of 4.8 and 24.2 are no tie, whatever the likelihood of their shapes says."""
    small = leaves(0.1)
    for times, tied in ((1.9, ("b",)), (2.1, ())):
        models = {"": Said(20.0, 1000.0), "a": small, "b": Said(times * small.shape, 501.0)}
        assert choose(models)[0].ties == (tied,)


@pytest.mark.parametrize(
    ("excess_of_base", "left_by_b", "tied"),
    [(15.0, 0.19, ("b",)), (15.0, 0.21, ()), (20.0, 0.19, ())],
)
def test_an_effect_of_which_another_form_looks_like_the_named_one_is_tied_with_it(
    choose, excess_of_base, left_by_b, tied
):
    """A clock that is late fits a tube of second order to the floor, one of first order does not:
    it is tied where alone it would explain up to its form, be its error many times larger, but not
    where that is 3.8 floors.
    """
    b = Said(beyond(left_by_b * excess_of_base), 700.0)
    models = {"": Said(beyond(excess_of_base), 1000.0), "a": leaves(0.0), "b": b}
    problem = made_up_problem()
    assert choose(models, problem=problem)[0].ties == ((),)
    stands = SimpleNamespace(**vars(problem.classes["a"]) | {"stands_for": ("b",)})
    alike = replace(problem, classes={**problem.classes, "a": stands})
    assert choose(models, problem=alike)[0].ties == (tied,)


@pytest.mark.parametrize(("behind", "tied"), [(59.0, ("b",)), (61.0, ())])
def test_two_are_tied_that_another_form_of_their_equation_would_bring_near(choose, behind, tied):
    base = Said(beyond(EXCESS), 1503.0)
    models = {"": base, "a": leaves(0.1), "b": leaves(0.1, 500.0 + behind)}
    assert choose(models)[0].ties == (tied,)
    more = {"c": leaves(0.1, 561.0 - 1.5), "d": leaves(0.1, 561.0 - 1.2)}
    assert len(choose(models | more)[0].ties[0]) == 2
    implausible = replace(models["b"], at_limit=True)
    assert choose(models | {"b": implausible})[0].ties == ((),)


@pytest.mark.parametrize(("left_by_b", "tied"), [(0.0, ("b",)), (0.3, ())])
def test_another_form_that_misses_the_noise_is_not_tied_with_one_that_meets_it(
    choose, left_by_b, tied
):
    """Gent's stiffening fits to the noise, Yeoh's is off by far more than repeats scatter."""
    base = Said(beyond(EXCESS), 1503.0)
    models = {"": base, "a": leaves(0.0), "b": leaves(left_by_b, 530.0)}
    assert choose(models, problem=made_up_problem(dof=1e6))[0].ties == (tied,)


@pytest.mark.parametrize(
    ("left", "left_by_b", "tied"),
    [(0.2, 0.34, ("b",)), (0.2, 0.36, ()), (0.0, 0.34, ())],
)
def test_what_would_be_named_in_its_absence_is_tied_with_an_effect_of_another_form(
    choose, left, left_by_b, tied
):
    """An effect that leaves more than repeats scatter is not quite the one that is hidden."""
    models = {"": BASE, "a": leaves(left), "b": leaves(left_by_b, 700.0)}
    assert choose(models, problem=made_up_problem(dof=1e6))[0].ties == (tied,)


@pytest.mark.parametrize(("behind", "tied"), [(119.0, ("b",)), (121.0, ())])
def test_what_lasts_for_less_than_a_sample_is_told_from_others_less_well(
    choose, monkeypatch, behind, tied
):
    """How well it does hangs on what the input did between samples."""
    base = Said(beyond(EXCESS), 1503.0)
    models = {"": base, "a": leaves(0.1), "b": leaves(0.1, 500.0 + behind)}
    assert choose(models)[0].ties == ((),)
    monkeypatch.setattr(module, "is_between_samples", lambda data, fit, effect: effect.name == "a")
    assert choose(models)[0].ties == (tied,)


@pytest.mark.parametrize(("resolved", "ties"), [(False, {"b"}), (True, set())])
def test_what_samples_cannot_resolve_is_not_named_but_tied(choose, monkeypatch, resolved, ties):
    """Of a memory shorter than a sample only a product of parameters is known."""
    made = Landscape._one

    def scored(landscape, before, effect):
        found = made(landscape, before, effect)
        return replace(found, known=False, resolved=resolved) if effect == "b" else found

    monkeypatch.setattr(Landscape, "_one", scored)
    models = {"": Said(beyond(EXCESS), 1503.0), "a": leaves(0.1), "b": leaves(0.1, 530.0)}
    assert set(choose(models)[0].ties[0]) == ties
    models["b"] = leaves(0.1, 480.0)
    assert choose(models)[0].final.effects == ("a",)


def test_between_samples_few_are_causes_and_not_names(choose, monkeypatch):
    """Of lags "a", "b" and "c" and two other causes, each of which is a little behind."""
    problem, cause = made_up_problem(), {"cause": "lag"}
    lags = {one: SimpleNamespace(**vars(problem.classes[one]) | cause) for one in "abc"}
    problem = replace(problem, classes={**problem.classes, **lags})
    models = {"": Said(beyond(EXCESS), 1503.0), "a": leaves(0.1)}
    models |= {name: leaves(0.1, 501.0) for name in "bc"}
    models |= {name: leaves(0.1, 530.0 + n) for n, name in enumerate("def")}
    assert set(choose(models, problem=problem)[0].ties[0]) == {"b", "c"}
    monkeypatch.setattr(module, "is_between_samples", lambda data, fit, effect: effect.name == "b")
    assert set(choose(models, problem=problem)[0].ties[0]) == {"b", "c", "d", "e"}


@pytest.mark.parametrize("apart", [0.9, 1.1])
def test_unusual_ones_are_tied_where_there_are_few_others(choose, monkeypatch, apart):
    models = {"": BASE, "a": leaves(0.0, 500.0)}
    models |= {name: leaves(0.0, 501.0) for name in "bc"} | {"d": leaves(0.0, 500.5)}
    made = Landscape._one

    def unusual(landscape, before, effect):
        scored = made(landscape, before, effect)
        return replace(scored, unusual=apart) if effect == "d" else scored

    monkeypatch.setattr(Landscape, "_one", unusual)
    (tied,) = choose(models)[0].ties
    assert set(tied) == ({"b", "c", "d"} if apart < 1.0 else {"b", "c"})
    (tied,) = choose({name: said for name, said in models.items() if name != "c"})[0].ties
    assert set(tied) == {"b", "d"}


@pytest.mark.parametrize(("left", "tied"), [(0.2, ("b",)), (0.1, ())])
def test_without_repeats_the_same_holds_for_what_leaves_more_than_the_floor(choose, left, tied):
    models = {"": BASE, "a": leaves(left), "b": leaves(0.34, 700.0)}
    assert choose(models, problem=made_up_problem(gain_known=False))[0].ties == (tied,)


@pytest.mark.parametrize(("spread", "tied"), [(0.3, ("b",)), (0.0, ())])
def test_an_effect_that_predicts_as_well_within_the_scatter_of_protocols_is_tied(
    choose, monkeypatch, spread, tied
):
    """Though it is far behind in likelihood; not if it is a little worse in each of them."""
    original = made_up_fits.residual

    def uneven(problem, shape, gain=0.0):
        left = original(problem, shape, gain)
        odd = problem.data.table.fold % 2 == 1
        return left * np.where(odd & (shape == behind), 1.0 - spread, 1.0 + 0.02 * spread)

    behind = beyond(0.1 * EXCESS) + 0.01
    monkeypatch.setattr(made_up_fits, "residual", uneven)
    models = {"": BASE, "a": leaves(0.1), "b": Said(behind, 590.0)}
    chosen, _ = choose(models)
    assert chosen.final.effects == ("a",) and chosen.ties == (tied,)


@pytest.mark.parametrize(("error", "tied"), [(1.1, ("b",)), (1.3, ())])
def test_what_leaves_a_larger_error_is_not_tied_however_well_it_predicts_what_weighs(
    choose, monkeypatch, error, tied
):
    """In the gains of runs, which weigh nothing here, though protocols scatter."""
    made = Landscape._one

    def weighed(landscape, before, effect):
        scored = made(landscape, before, effect)
        variance = np.r_[1e6, np.ones(len(scored.fit.variance) - 1)]
        return replace(scored, fit=replace(scored.fit, variance=variance))

    monkeypatch.setattr(Landscape, "_one", weighed)
    gain = np.sqrt(error**2 - 0.99**2)
    models = {"": BASE, "a": Said(1.0, 500.0), "b": Said(0.99, 590.0, gain=gain)}
    assert choose(models)[0].ties == (tied,)


def test_ties_come_nearest_first(choose):
    models = {
        "": BASE,
        **{n: leaves(0.1, 500.0 + d) for n, d in zip("abc", (0, 5, 2), strict=True)},
    }
    assert choose(models)[0].ties == (("c", "b"),)


def test_each_effect_of_a_pair_has_those_that_would_do_in_its_place(choose):
    models = {
        **pairs(0.0, 0.7),
        "c": leaves(0.9, 900.0),
        "ac": leaves(0.01, 104.0),
        "bc": leaves(0.5, 300.0),
    }
    chosen, _ = choose(models)
    assert chosen.final.effects == ("a", "b")
    assert chosen.ties == ((), ("c",))


def test_nothing_is_tied_where_nothing_is_named(choose):
    assert choose({"": BASE, "a": leaves(0.9), "b": leaves(0.9)})[0].ties == ()


# ---------------------------------------------------------------- errors
def test_the_held_out_error_counts_unless_the_folds_are_few():
    said = Said(3.0, fitted=2.0)
    many, few = made_up_problem(folds=3), made_up_problem(folds=2)
    assert error_of(many, made_up_model(many, "", said)) == pytest.approx(3.0)
    assert error_of(few, made_up_model(few, "", said)) == pytest.approx(2.0)
    heavy = Said(2.0, fitted=3.0)  # of shapes that weigh more than sizes
    assert error_of(few, made_up_model(few, "", heavy)) == pytest.approx(2.0)
    assert shape_error(many, made_up_model(many, "", said)) == pytest.approx(3.0)
    assert shape_error(few, made_up_model(few, "", said)) == pytest.approx(2.0)


def test_the_error_in_shape_leaves_out_the_gains_of_runs():
    problem = made_up_problem()
    scored = made_up_model(problem, "", Said(3.0, gain=4.0))
    assert error_of(problem, scored) == pytest.approx(5.0)
    assert shape_error(problem, scored) == pytest.approx(3.0)


def test_the_excess_is_what_lies_beyond_the_floor_in_squares():
    problem = made_up_problem(level=2.0)
    assert excess(problem, made_up_model(problem, "", Said(2.5))) == pytest.approx(1.5)
    assert excess(problem, made_up_model(problem, "", Said(1.9))) == 0.0
    assert not material(problem, made_up_model(problem, "", Said(2.23)))
    assert material(problem, made_up_model(problem, "", Said(2.25)))


def test_of_error_and_shape_that_counts_of_which_less_is_left():
    problem = made_up_problem()
    before = made_up_model(problem, "", Said(4.0, gain=3.0))
    shape = np.sqrt(0.99)  # of the floor's hundred coefficients one is the gain
    gains_stay = made_up_model(problem, "a", Said(1.0, gain=3.0))
    left = np.sqrt(1.0 - shape**2) / np.sqrt(16.0 - shape**2)
    assert share_left(problem, gains_stay, before) == pytest.approx(left)
    shape_stays = made_up_model(problem, "a", Said(4.0, gain=0.0))
    assert share_left(problem, shape_stays, before) == pytest.approx(np.sqrt(15.0 / 24.0))


def test_of_no_excess_all_is_left():
    problem = made_up_problem()
    good = made_up_model(problem, "", Said(0.9))
    assert share_left(problem, good, good) == 1.0


# ---------------------------------------------------------------- what would have shown
def detectable(choose, threshold, **changed):
    """The stated smallest value of an effect, given its signature at some values of it."""
    problem = made_up_problem()
    found = replace(signature_of(problem, 0, strengths=(1.0, 2.0, 4.0)), **changed)
    scored = made_up_model(problem, ["pressure_offset"], Said(1.0), signature=found)
    chosen, _ = choose({"": BASE, "a": leaves(0.9)})
    chosen = replace(chosen, singles=(scored,), threshold=threshold)
    return [(d.name, d.parameter, d.smallest) for d in detectable_effects(problem, chosen)]


def test_the_smallest_value_that_shows_lies_between_one_that_does_and_one_that_does_not(choose):
    ((name, parameter, smallest),) = detectable(choose, 6.0, size=np.full(3, 10.0))
    assert (name, parameter) == ("pressure_offset", "offset")
    # strengths 4/6 at 2 and 16/6 at 4: 1 in the logarithm between them
    share = np.log(16.0 / 6.0) / np.log(4.0)
    assert smallest == pytest.approx(4.0 - share * 2.0)


def test_an_effect_must_also_be_half_the_floor_to_show(choose):
    # sizes: sqrt(2) of half the floor at 4, its half at 2
    ((*_, smallest),) = detectable(
        choose, 0.1, size=0.125 * np.sqrt(2.0) * np.array([1.0, 2.0, 4.0])
    )
    assert smallest == pytest.approx(3.0)


def test_sizes_count_in_squares_beside_what_noise_hides(choose):
    # strengths: 4 by noise at 4; 1/4 at 2, by a size of half of half the floor
    change = np.zeros((3, 1200))
    change[:, 0] = 2.0
    ((*_, smallest),) = detectable(choose, 1.0, change=change, size=np.array([0.0, 0.25, 5.0]))
    assert smallest == pytest.approx(3.0)


def test_of_an_effect_without_parameters_nothing_is_stated(choose):
    problem = made_up_problem()
    bare = SimpleNamespace(name="bare", parameters=())
    problem = replace(problem, classes={**problem.classes, "bare": bare})
    scored = made_up_model(problem, ["bare"], Said(1.0), signature=signature_of(problem, 0))
    chosen, _ = choose({"": BASE, "a": leaves(0.9)})
    assert detectable_effects(problem, replace(chosen, singles=(scored,), threshold=0.5)) == []


def test_where_all_values_show_the_weakest_is_stated(choose):
    assert detectable(choose, 0.8, size=np.full(3, 10.0))[0][2] == 1.0


def test_of_an_effect_that_never_shows_nothing_is_stated(choose):
    assert detectable(choose, 100.0, size=np.full(3, 10.0)) == []


def test_other_parameters_are_taken_at_their_middle_value(choose):
    grid = [[first, second] for first in (1.0, 4.0) for second in (0.1, 0.2, 0.3, 0.4)]
    change = np.zeros((8, 1200))
    change[:, 0] = [9.0, 9.0, 1.0, 9.0, 9.0, 9.0, 2.0, 9.0]
    ((*_, smallest),) = detectable(
        choose, 2.0, values=np.array(grid), change=change, size=np.full(8, 10.0)
    )
    assert smallest == pytest.approx(2.5)  # strengths 1/2 at 1 and 2 at 4


def test_finer_forms_are_found_at_any_place_of_a_hand():
    classes = at_places(load_hand("rbo_hand_2"), effect_classes())
    problem = SimpleNamespace(classes=classes)
    refined = ["channel_gain[a]", "channel_gain[b]", "ogden"]
    assert finer_forms(problem, refined, ["actuator_scatter[ring]"]) == refined[:2]
    assert finer_forms(problem, refined, ["mount_tilt[ring]", "mooney_rivlin"]) == ["ogden"]
