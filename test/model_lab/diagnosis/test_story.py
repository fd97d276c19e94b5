"""What helps where nothing explains the error, on made-up fits."""

from dataclasses import replace

import numpy as np
import pytest
from made_up_fits import Said, made_up_model, made_up_problem

from model_lab.diagnosis.growth import Growth
from model_lab.diagnosis.story import helping
from model_lab.fitting.problem import HeldOut

STIFFENING, MEMORY = "yeoh_stiffening", "hysteresis"


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
    return [scored.added for scored in helping(base, Growth(tuple(made), base))]


@pytest.mark.parametrize(("error", "answer"), [(49.0, [STIFFENING]), (51.0, [])])
def test_an_effect_helps_if_it_halves_the_held_out_error(error, answer):
    assert helped([((STIFFENING,), [error] * 6)]) == answer


@pytest.mark.parametrize(("folds", "answer"), [(2, []), (4, [STIFFENING])])
def test_it_must_do_so_in_most_protocols(folds, answer):
    errors = [5.0] * folds + [60.0] * (6 - folds)
    assert helped([((STIFFENING,), errors)]) == answer


def test_a_second_effect_helps_if_it_halves_what_the_first_leaves():
    first, second = ((STIFFENING,), [30.0] * 6), ((STIFFENING, MEMORY), [14.0] * 6)
    assert helped([first], [second]) == [STIFFENING, MEMORY]
    assert helped([first], [((STIFFENING, MEMORY), [20.0] * 6)]) == [STIFFENING]
    assert helped([first], [(("dead_zone", MEMORY), [1.0] * 6)]) == [STIFFENING]


def test_nothing_helps_where_nothing_is_proven():
    assert helped() == [] == helped([])
