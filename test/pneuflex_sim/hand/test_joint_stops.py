"""What is said when pressure asks joints to bend beyond their stops."""

import warnings

import numpy as np
import pytest

from pneuflex_sim.hand.joint_stops import JointStops
from pneuflex_sim.hand.layout import build_layout
from softhand_model.dynamics.joint_springs import STOP_ANGLE
from softhand_model.hand.actuator import load_actuator
from softhand_model.hand.hand import load_hand
from softhand_model.model_file import load_model
from thesis.chapter_3_and_5.stand import FingerStand

P5 = load_actuator("P5")


def stops(hand, segments):
    return JointStops(build_layout(load_hand(hand), segments, load_model("base")))


@pytest.mark.parametrize("segments", [5, 8])
def test_the_lowest_pressure_is_where_the_tip_has_turned_by_all_stops(segments):
    """A P5 is even along its length, so that its joints come to their stops together."""
    found = stops("rbo_hand_1", segments).lowest
    assert P5.tip_angle(found) == pytest.approx(segments * STOP_ANGLE, rel=1e-4)


def test_shipped_hand_of_five_segments_stops_within_its_limit_and_one_of_seventeen_does_not():
    assert stops("rbo_hand_1", 5).lowest == pytest.approx(113e3, abs=1e3)
    assert stops("rbo_hand_1", 17).lowest > 250e3
    assert stops("rbo_hand_2", 5).lowest > 80e3


def test_the_warning_names_channel_pressure_joint_and_segments_and_comes_once():
    found = stops("rbo_hand_1", 5)
    with pytest.warns(RuntimeWarning) as told:
        found.look(np.array([150e3]))
        found.look(np.array([200e3]))
    (words,) = [str(one.message) for one in told]
    assert words == found.warning
    enough = int(np.ceil(P5.tip_angle(250e3) / STOP_ANGLE))
    for part in ("joint right_", "150 kPa in channel a", "138 deg", "250 kPa"):
        assert part in words
    assert f"with {enough} segments instead of 5" in words


def test_a_hand_that_is_not_filled_that_far_works_on_in_silence():
    found = stops("rbo_hand_1", 5)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        found.look(np.array([100e3]))
    assert found.warning == ""


def test_a_channel_counts_for_the_actuators_that_it_feeds():
    found = stops("rbo_hand_2", 3)
    pressures = np.zeros(4)
    pressures[3] = 2.0 * found.lowest
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        found.look(pressures)
    pressures[0] = 1.01 * found.lowest
    with pytest.warns(RuntimeWarning, match="in channel a"):
        found.look(pressures)


def test_a_simulated_finger_warns_when_it_is_filled_too_far():
    with FingerStand(P5, 5) as stand, pytest.warns(RuntimeWarning, match="joint finger_"):
        for _ in range(3):
            stand.step(150e3)
