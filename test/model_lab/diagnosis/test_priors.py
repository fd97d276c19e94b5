"""What speaks for or against a fitted model besides its error."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from toy_forward import toy_set

from model_lab.diagnosis.priors import is_between_samples, is_resolved, seen_at_rest, unusual
from model_lab.fitting.fit import Likelihood
from softhand_model.effects import effect_classes


def parameter(effect, typical, logarithmic=False):
    made = SimpleNamespace(effect=effect, typical=typical, logarithmic=logarithmic, spread=np.inf)
    made.low, made.high, made.name = 1e-3, 1e3, "p"
    return made


@pytest.mark.parametrize(
    ("made", "value", "deviance"),
    [
        (parameter("viscoelasticity", (0.05, 0.5)), 0.3, 0.0),
        (parameter("viscoelasticity", (0.05, 0.5)), 0.5 + 0.225, 1.0),
        (parameter("viscoelasticity", (0.05, 0.5)), 4.4, (3.9 / 0.225) ** 2),
        (parameter("tube_lag", (0.1, 10.0), True), 0.01, 1.0),
        (parameter(None, (0.9, 1.1)), 5.0, 0.0),
    ],
)
def test_parameters_outside_of_their_usual_ranges_are_unlikely(made, value, deviance):
    forward = SimpleNamespace(parameters=[made])
    likelihood = Likelihood(forward, None, np.ones(1))
    found = SimpleNamespace(likelihood=likelihood, values=np.array([value]))
    assert unusual(found) == pytest.approx(deviance)


def at_rest(first, zero, steady=False):
    """Evidence of first readings [Pa] for a gauge's fitted zero [Pa]; None: none is fitted."""
    data = toy_set(np.random.default_rng(0), runs=len(first))
    runs = [
        replace(
            run, steady=steady, columns={**run.columns, "pressure": run.columns["pressure"] + at}
        )
        for run, at in zip(data.runs, first, strict=True)
    ]
    names = ["modulus_scale[all]", *([] if zero is None else ["pressure_offset.offset"])]
    found = SimpleNamespace(
        likelihood=SimpleNamespace(names=names), values=np.array([1.0, zero or 0.0])[: len(names)]
    )
    return seen_at_rest(replace(data, runs=tuple(runs)), found)


def test_a_gauge_that_reads_its_fitted_zero_at_rest_speaks_for_it():
    first = 1000.0 + np.random.default_rng(1).normal(0.0, 20.0, 12)
    assert at_rest(first, 1000.0) > 60.0 > at_rest(first, 800.0) > 20.0


@pytest.mark.parametrize("zero", [None, -1000.0, 3000.0])
def test_a_zero_that_the_gauge_does_not_read_has_nothing_for_it(zero):
    assert at_rest(np.full(12, 1000.0), zero) == 0.0


def test_gauges_that_read_nothing_at_rest_say_nothing_against_a_zero():
    assert at_rest(np.zeros(12), 1000.0) == 0.0


def test_runs_that_do_not_start_at_rest_say_nothing():
    assert at_rest(np.full(12, 1000.0), 1000.0, steady=True) == 0.0


@pytest.mark.parametrize(
    ("effect", "time", "answer"),
    [
        ("viscoelasticity", {"relaxation_time": 0.024}, False),
        ("viscoelasticity", {"relaxation_time": 0.06}, True),
        ("creep", {"onset_time": 0.024}, True),
        ("tube_lag", {"time_constant": 0.024}, True),
        ("hysteresis", {}, True),
    ],
)
def test_of_two_parameters_a_time_far_below_that_between_samples_is_not_told(effect, time, answer):
    data = toy_set(np.random.default_rng(0))  # sampled at 10 Hz
    kind = effect_classes()[effect]
    values = {f"{effect}.{p.name}": 1.0 for p in kind.parameters}
    values |= {f"{effect}.{name}": value for name, value in time.items()}
    likelihood = SimpleNamespace(names=list(values))
    found = SimpleNamespace(likelihood=likelihood, values=np.array(list(values.values())))
    assert is_resolved(data, found, kind) == answer


@pytest.mark.parametrize(("time", "answer"), [(0.003, False), (0.024, True)])
def test_a_lag_that_is_nothing_between_samples_is_not_told_beside_other_effects(time, answer):
    """What the input did between samples looks like one."""
    data, kind = toy_set(np.random.default_rng(0)), effect_classes()["tube_lag"]
    likelihood = SimpleNamespace(names=["tube_lag.time_constant"])
    found = SimpleNamespace(likelihood=likelihood, values=np.array([time]))
    assert is_resolved(data, found, kind, beside=True) == answer
    assert is_resolved(data, found, kind)


@pytest.mark.parametrize(
    ("effect", "values", "answer"),
    [
        ("tube_lag", {"time_constant": 0.09}, True),
        ("tube_lag", {"time_constant": 0.11}, False),
        ("clock_offset", {"offset": -0.09, "drift": 0.0}, True),
        ("dead_zone", {"threshold": 0.01}, False),
    ],
)
def test_times_below_that_between_samples_hang_on_what_nobody_has_seen(effect, values, answer):
    data, kind = toy_set(np.random.default_rng(0)), effect_classes()[effect]  # sampled at 10 Hz
    likelihood = SimpleNamespace(names=[f"{effect}.{name}" for name in values])
    found = SimpleNamespace(likelihood=likelihood, values=np.array(list(values.values())))
    assert is_between_samples(data, found, kind) == answer
