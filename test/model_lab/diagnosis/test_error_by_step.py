"""What helps where nothing explains the error, on made-up fits."""

from dataclasses import replace

import numpy as np
import pytest
from made_up_fits import Said, made_up_model, made_up_problem

from model_lab.diagnosis import error_by_step as module
from model_lab.diagnosis.error_by_step import greater_part, helping, is_missed, share_removed
from model_lab.diagnosis.forward_selection import ForwardSelection
from model_lab.fitting.held_out import HeldOut

STIFFENING, MEMORY, DRIFT = "yeoh_stiffening", "hysteresis", "sensor_drift"


def model(problem, effects, folds):
    """A model with these held-out errors (folds,)."""
    errors = np.array(folds, float)
    made = made_up_model(problem, effects, Said(float(np.sqrt(np.mean(errors**2)))))
    return replace(made, held_out=HeldOut(made.held_out.residual, errors**2))


def helped(*sizes):
    """Names of what helps, given the proven models of each size as (effects, errors)."""
    problem = made_up_problem()
    base = model(problem, (), [100.0] * 6)
    made = [tuple(model(problem, *one) for one in models) for models in sizes]
    return [scored.added for scored in helping(problem, base, ForwardSelection(tuple(made), base))]


@pytest.mark.parametrize(("error", "answer"), [(49.0, [STIFFENING]), (51.0, [])])
def test_an_effect_helps_if_it_halves_the_held_out_error(error, answer):
    assert helped([((STIFFENING,), [error] * 6)]) == answer


def test_a_second_effect_helps_if_it_halves_what_the_first_leaves():
    first, second = ((STIFFENING,), [30.0] * 6), ((STIFFENING, MEMORY), [14.0] * 6)
    assert helped([first], [second]) == [STIFFENING, MEMORY]
    assert helped([first], [((STIFFENING, MEMORY), [20.0] * 6)]) == [STIFFENING]
    assert helped([first], [(("dead_zone", MEMORY), [1.0] * 6)]) == [STIFFENING]


def test_nothing_helps_where_nothing_is_proven():
    assert helped() == [] == helped([])


# ---------------------------------------------------------------- the greater part
def parts(*errors, floor=0.9):
    """(names of what explains the greater part, its share), given held-out errors by effects."""
    problem = made_up_problem()
    problem = replace(problem, floor=replace(problem.floor, total=floor))
    base = model(problem, (), [1.2] * 6)
    proven = [model(problem, (name,), [error] * 6) for name, error in errors]
    found = greater_part(problem, base, proven)
    share = share_removed(problem, found[0], base) if found else None
    return [one.added for one in found], share


def test_an_effect_may_explain_most_of_an_error_near_the_floor_without_halving_it():
    assert parts(("tube_lag", 1.0), (MEMORY, 1.15)) == (
        ["tube_lag"],
        pytest.approx((1.2**2 - 1.0) / (1.2**2 - 0.9**2)),
    )
    assert parts(("tube_lag", 1.1)) == ([], None)  # it removes 36 %


def test_effects_of_one_cause_are_one_and_many_causes_are_none():
    lags = [("tube_lag", 1.0), ("angle_sensor_lag", 1.0)]
    others = [(STIFFENING, 1.0), (MEMORY, 1.0)]
    assert parts(*lags, *others)[0] == [name for name, _ in (*lags, *others)]
    assert parts(*lags, *others, ("dead_zone", 1.0))[0] == []


# ---------------------------------------------------------------- several that help together
ALONE = {(STIFFENING,): 60.0, (MEMORY,): 80.0, (DRIFT,): 90.0}
IN_TWOS = {(STIFFENING, MEMORY): 35.0, (STIFFENING, DRIFT): 45.0, (MEMORY, DRIFT): 70.0}
ALL = (STIFFENING, MEMORY, DRIFT)


@pytest.fixture
def together(monkeypatch):
    """Names of what helps, given the errors of all models by their effects."""

    def together(errors, folds=6, order=1):
        problem = made_up_problem(folds=folds)
        spread = np.linspace(0.95, 1.05, folds)  # of the errors in the protocols

        def made(effects):
            error = errors[tuple(sorted(effects, key=ALL.index))]
            folds = error * spread if np.ndim(error) == 0 else error
            return model(problem, effects[::order], folds)

        def without(problem, before, effect):
            return made(tuple(name for name in before.effects if name != effect))

        monkeypatch.setattr(module, "score_without", without)
        sizes = [
            tuple(made(effects) for effects in errors if len(effects) == size) for size in (1, 2, 3)
        ]
        base = model(problem, (), 100.0 * spread)
        forward = ForwardSelection(tuple(sizes), base)
        return [scored.added for scored in helping(problem, base, forward)]

    return together


@pytest.mark.parametrize(("error", "answer"), [(20.0, list(ALL)), (34.0, [])])
def test_several_help_that_only_together_take_the_error_to_a_third(together, error, answer):
    assert together({**ALONE, **IN_TWOS, ALL: error}) == answer


def test_each_effect_is_told_once_in_whichever_order_its_models_were_found(together):
    assert together({**ALONE, **IN_TWOS, ALL: 20.0}, order=-1) == list(ALL)


def test_one_of_several_that_is_not_missed_does_not_help(together):
    errors = {**ALONE, **IN_TWOS, (STIFFENING, MEMORY): 30.0, ALL: 27.0}
    assert together(errors) == [STIFFENING, MEMORY]


def test_effects_that_halve_the_error_each_are_enough(together):
    errors = {**ALONE, **IN_TWOS, (STIFFENING,): 30.0, (STIFFENING, MEMORY): 20.0, ALL: 10.0}
    assert together(errors) == [STIFFENING]


def test_two_protocols_do_not_tell_what_helps_together(together):
    assert together({**ALONE, **IN_TWOS, ALL: 20.0}, folds=2) == []


@pytest.mark.parametrize(
    ("gone", "missed"),
    [
        ([1.5] * 6, False),  # an error that is larger by 22 % only
        ([1.6] * 6, True),
        ([30.0, 0.4, 0.4, 0.4, 0.4, 0.4], False),  # in one protocol
    ],
)
def test_an_effect_is_missed_by_much_and_not_in_one_protocol_alone(gone, missed):
    scatter = np.linspace(0.99, 1.01, 6)
    assert is_missed(np.ones(6), np.array(gone) * scatter) is missed
