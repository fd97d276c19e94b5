"""The model file that RBO Hand 1 is meant to be run with."""

import numpy as np
import pytest

from softhand_model.chain.chain import discretise
from softhand_model.hand.hand import load_hand
from softhand_model.model_file import load_model

GRASPING = 210e3  # [Pa], section 8.1.2
MARKER = 0.017  # [m] across, Table 8.1


def inner_diameter(model, segments=10):
    """Of a P5 that nothing touches [m]."""
    chain = load_hand("rbo_hand_1").chain("middle")
    finger = discretise(chain, segments, load_model(model))
    bend = finger.free_rotation(0.0, [GRASPING, GRASPING])[:, 1].sum()
    return 2.0 * 0.120 / bend


def test_fully_flexed_fingers_leave_more_room_than_the_marker_takes():
    """The marker's "outer diameter is smaller than the inner diameter of the fully flexed fingers"
    (section 8.1.2); by no more than the observation asks for.
    """
    assert MARKER < inner_diameter("rbo_hand_1") < 1.05 * MARKER


def test_the_bare_model_stays_an_option_and_contradicts_the_marker():
    for bare in ("base", "gravity"):
        assert inner_diameter(bare) == pytest.approx(7.9e-3, abs=0.05e-3)


def test_weight_is_that_of_the_model_that_the_other_hands_ship_with():
    assert load_model("rbo_hand_1").gravity_scale == load_model("gravity").gravity_scale


@pytest.mark.parametrize("segments", [6, 17])
def test_the_curl_does_not_depend_on_the_segments(segments):
    assert np.isclose(inner_diameter("rbo_hand_1", segments), inner_diameter("rbo_hand_1"))
