"""Intervals of parameters, on made-up fits."""

import pytest
from made_up_fits import Said, made_up_model, made_up_problem
from scipy.stats import t as student

from model_lab.diagnosis.result import estimate
from model_lab.rules import RULES


@pytest.mark.parametrize("std", [0.0, 0.002, 0.2])
def test_an_interval_holds_what_the_form_of_the_equation_leaves_out(std):
    """Twelve runs and three parameters, the value 1: half-width t times the root of the sum of the
    squares of both errors, the stated standard error being that of the fit alone.
    """
    found = estimate(made_up_model(made_up_problem(), ("a",), Said(1.0, std=std)), 2)
    expected = student.ppf(0.975, 9) * (std**2 + RULES.form_error**2) ** 0.5
    low, high = found.interval
    assert (found.value - low, high - found.value) == pytest.approx((expected, expected))
    assert found.std == std
