"""Hands of few segments, for what the lab does with a set however fine its model is."""

import pytest

from model_lab.experiments import hand_pose
from model_lab.fitting import problem

COARSE = 5  # segments of an actuator, as in the simulator


@pytest.fixture(scope="module")
def coarse_hands():
    """The lab makes and predicts sets of hands by models of few segments."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(hand_pose, "HAND_SEGMENTS", COARSE)
        patch.setattr(problem, "own_error", lambda data, model: 0.0)  # the sets are cut alike
        yield
