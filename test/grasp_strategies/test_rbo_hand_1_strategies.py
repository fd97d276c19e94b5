"""The strategies of RBO Hand 1 that use the environment, on the objects that they were tuned on."""

import numpy as np
import pytest

from grasp_strategies.strategy import load_strategy
from softhand_trials.trials import Placement, StartedScene, TrialSettings

LYING, UPRIGHT = (np.pi / 2, 0.0, 0.0), (0.0, 0.0, 0.0)
PUSH, SURFACE, EDGE = "rbo_hand_1_push", "rbo_hand_1_surface", "rbo_hand_1_edge"
CASES = {  # object, how it rests and where it lies [m]: at the reference place, 40 mm from the edge
    PUSH: ("cylinder", UPRIGHT, (0.0325, -0.0325)),
    SURFACE: ("cylinder", LYING, (0.0325, -0.0875)),
    EDGE: ("rod", LYING, (-0.005, 0.0)),
}


def trial(name, step=0.005, shift=(0.0, 0.0), **variant):
    thing, rpy, place = CASES[name]
    world = load_strategy(name).tried_with
    started = StartedScene(
        TrialSettings(
            name,
            object=thing,
            object_rpy=rpy,
            scene=variant.pop("scene", world.scene),
            model=world.model,
            segments=world.segments,
            step=step,
            **variant,
        )
    )
    return started.run(Placement(tuple(np.add(place, shift))))


@pytest.mark.parametrize("name", CASES)
def test_a_strategy_lifts_the_object_that_it_was_tuned_on(name):
    result = trial(name)
    assert result.gripped and result.lift_height > 0.1 and result.slip < 5e-3, result.reason


@pytest.mark.parametrize("name", [PUSH, SURFACE])
def test_the_place_of_the_object_may_be_20_mm_off(name):
    assert trial(name, shift=(0.020, 0.0)).gripped
    assert trial(name, shift=(-0.020, 0.0)).gripped


def test_a_hand_that_is_not_inflated_pushes_and_lifts_nothing():
    assert trial(PUSH, air_scale=0.0).outcome == "none"


def test_a_hand_that_does_not_advance_misses_the_object():
    assert trial(PUSH, without=("advance",)).outcome == "none"


def test_a_far_object_is_lifted_because_the_hand_rolls_over_it():
    assert trial(SURFACE, shift=(0.040, 0.0)).gripped
    assert not trial(SURFACE, shift=(0.040, 0.0), without=("roll",)).gripped


def test_without_an_edge_nothing_is_pulled_over_it():
    assert not trial(EDGE, scene="table").gripped


@pytest.mark.parametrize("height", [-0.020, 0.020])
def test_the_hand_may_come_20_mm_too_low_or_too_high_over_the_edge(height):
    assert trial(EDGE, displacement=(0.0, 0.0, height)).gripped
