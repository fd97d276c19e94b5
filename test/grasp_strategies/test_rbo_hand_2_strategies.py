"""Each shipped grasp of RBO Hand 2 once in process, at the step of the maps."""

import pytest

from softhand_trials.trials import Placement, StartedScene, TrialSettings, run_in_process

BEFORE_THE_CORNER = 0.05  # x of the object [m], 100 mm before the foot of the wall


def result_of(strategy, thing, x=0.0, **settings):
    started = StartedScene(TrialSettings(strategy=strategy, object=thing, step=0.005, **settings))
    scene = started.place(Placement(offset=(x, 0.0)))
    return run_in_process(scene, started.strategy, ())


@pytest.mark.parametrize(
    ("strategy", "thing"),
    [
        ("rbo_hand_2_ball", "ball"),
        ("rbo_hand_2_lying_cylinder", "tube"),
        ("rbo_hand_2_lying_cylinder", "water_bottle"),
    ],
)
def test_rbo_hand_2_lifts_ball_tube_and_bottle_from_the_table(strategy, thing):
    result = result_of(strategy, thing)
    assert result.gripped, result.reason
    assert result.completed


def test_rbo_hand_2_slides_a_thin_cylinder_to_a_wall_of_60_deg_and_lifts_it():
    at_wall = {"scene": "wall", "wall_inclination": 60.0}
    result = result_of("rbo_hand_2_slide_to_wall", "thin_cylinder", BEFORE_THE_CORNER, **at_wall)
    assert result.gripped, result.reason


def test_without_a_wall_the_slide_to_the_wall_lifts_nothing():
    result = result_of("rbo_hand_2_slide_to_wall", "thin_cylinder", BEFORE_THE_CORNER)
    assert not result.gripped
    assert result.lift_height < 0.05
