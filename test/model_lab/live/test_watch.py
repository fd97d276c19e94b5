"""What the monitor says of model and actuators, at which level."""

import math

import numpy as np
import pytest

from model_lab.live.prediction import Comparison, LivePrediction
from model_lab.live.watch import ANGLE, PRESSURE, Limits, ResidualWindow, Watch
from softhand_common.status import Level
from softhand_model.hand.hand import load_hand
from softhand_model.model_file import Model, load_model

SECOND = 10**9


def compared(seconds, residual, settled=True):
    return Comparison(
        round(seconds * SECOND),
        ("finger",),
        np.array([1.0 + residual]),
        np.array([1.0]),
        np.array([settled]),
    )


@pytest.fixture
def prediction():
    return LivePrediction(load_hand("single_finger"), Model())


@pytest.fixture
def watch(prediction):
    return Watch(prediction, "my.yaml", 5.0, Limits(warn_above=0.05, stale_after=2.0))


def reports(watch, now=0.0):
    return {report.name: report for report in watch.reports(now)}


def test_the_window_averages_settled_samples_of_its_time_alone():
    window = ResidualWindow(("finger",), 5.0)
    for seconds, residual, settled in (
        (0.0, 9.0, True),  # too old
        (2.0, 0.3, True),
        (4.0, 9.0, False),  # moving
        (6.0, -0.4, True),
    ):
        window.add(compared(seconds, residual, settled))
    recent = window.recent("finger")
    assert recent.rms == pytest.approx(math.sqrt((0.3**2 + 0.4**2) / 2))
    assert recent.largest == pytest.approx(0.4)
    assert (recent.samples, recent.settled) == (3, 2)


def test_a_small_residual_is_ok_and_told_in_degrees(watch):
    watch.take(compared(1.0, 0.01), 0.0)
    finger = reports(watch)["finger"]
    assert finger.level == Level.OK
    assert finger.message == "residual 0.57 deg rms"
    assert finger.values["residual, rms [deg]"] == "0.573"


def test_a_residual_above_the_threshold_is_a_warning_that_names_contact(watch):
    watch.take(compared(1.0, -0.06), 0.0)
    finger = reports(watch)["finger"]
    assert finger.level == Level.WARN
    assert "3.44 deg" in finger.message
    assert "above 2.86 deg" in finger.message
    assert "contact" in finger.message


def test_a_hand_that_only_moves_is_not_judged(watch):
    watch.take(compared(1.0, 0.5, settled=False), 0.0)
    finger = reports(watch)["finger"]
    assert finger.level == Level.OK
    assert "moving" in finger.message
    assert finger.values["samples"] == "1"


@pytest.mark.parametrize(
    ("heard", "words"),
    [
        ([], [f"no message on {PRESSURE} and {ANGLE}"]),
        ([PRESSURE], [f"no message on {ANGLE}"]),
        ([ANGLE], [f"no message on {PRESSURE}"]),
        ([PRESSURE, ANGLE], ["no such actuator", "stamps"]),
    ],
)
def test_without_a_comparison_it_is_stale_and_says_what_is_silent(watch, heard, words):
    for topic in heard:
        watch.heard(topic, 9.0)
    finger = reports(watch, 10.0)["finger"]
    assert finger.level == Level.STALE
    for word in words:
        assert word in finger.message


def test_it_turns_stale_when_comparisons_end(watch):
    watch.take(compared(1.0, 0.01), 10.0)
    assert reports(watch, 12.0)["finger"].level == Level.OK
    assert reports(watch, 12.1)["finger"].level == Level.STALE


def test_a_clock_set_back_warns_for_a_while_and_empties_the_window(watch, prediction):
    watch.take(compared(100.0, 0.5), 0.0)
    prediction.set_back += 1
    watch.take(compared(0.0, 0.01), 1.0)
    assert reports(watch, 1.0)["finger"].message == "residual 0.57 deg rms"
    model = reports(watch, 1.0)["model"]
    assert model.level == Level.WARN
    assert "set back" in model.message
    assert reports(watch, 12.0)["model"].level == Level.OK


def test_a_refused_message_is_named_for_a_while_and_counted(watch):
    watch.refuse("pneumaticbox/state: effort: expected 1 values, got 0", 0.0)
    model = reports(watch, 1.0)["model"]
    assert model.level == Level.WARN
    assert "effort" in model.message
    assert reports(watch, 11.0)["model"].level == Level.OK
    assert reports(watch, 11.0)["model"].values["refused messages"] == "1"


def test_a_model_that_has_no_equilibrium_is_an_error(watch):
    watch.take(compared(1.0, 0.5), 0.0)
    watch.fail("under the effects bad the rubber has no equilibrium at 5e+04 Pa", 0.0)
    assert reports(watch, 1.0)["model"].level == Level.ERROR
    assert "5e+04 Pa" in reports(watch, 1.0)["model"].message
    assert reports(watch, 1.0)["finger"].values["samples"] == "0"


def test_the_model_is_named_with_its_effects_and_what_it_leaves_out():
    watch = Watch(
        LivePrediction(load_hand("rbo_hand_2"), load_model()), "heavy.yaml", 5.0, Limits(0.05, 2.0)
    )
    model = reports(watch)["model"]
    assert model.values["model file"] == "heavy.yaml"
    assert model.values["effects"] == "gravity"
    assert "contact shows as residual" in model.message
    assert "weight is left out" in model.message
