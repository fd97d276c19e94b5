"""The judge of an episode, on observations that are made up."""

import numpy as np
import pytest

from grasp_strategies.pose import IDENTITY_QUATERNION
from grasp_strategies.scene import Observation
from grasp_strategies.strategy import Success
from softhand_gym.hold import HoldWatch

HAND = frozenset({"thumb", "index"})
STEP = 0.01  # [s]


def seen(time, rise=0.0, touching=HAND, slip=0.0):
    """The object so high above the table [m], shifted in the hand by a slip [m]."""
    wrist, zeros = np.array([0.0, 0.0, 0.2 + rise]), np.zeros(3)
    place = np.array([slip, 0.0, 0.03 + rise])
    turn = IDENTITY_QUATERNION
    return Observation(
        time, wrist, turn, zeros, place, turn, np.zeros(2), np.zeros(2), frozenset(touching)
    )


@pytest.fixture
def watch():
    return HoldWatch(Success(), HAND, seen(0.0, touching={"table"}))


def test_a_hold_of_one_second_counts_wherever_it_begins(watch):
    watch.watch(seen(0.5, 0.06))
    assert watch.merit == pytest.approx(0.6) and watch.hold_time == 0.0
    for k in range(100):
        assert not watch.over
        watch.watch(seen(1.0 + STEP * k, 0.12))
    assert watch.merit == pytest.approx(1.99)
    watch.watch(seen(2.0, 0.12))
    assert watch.outcome == "gripped" and watch.merit == pytest.approx(2.0)
    assert "held 1.00 s" in watch.reason


def test_after_a_slip_the_hold_begins_anew(watch):
    for k in range(60):
        watch.watch(seen(STEP * k, 0.12))
    watch.watch(seen(0.60, 0.12, slip=0.011))
    assert watch.hold_time == 0.0 and not watch.over
    for k in range(101):
        assert not watch.over
        watch.watch(seen(0.61 + STEP * k, 0.12, slip=0.011))
    assert watch.outcome == "gripped"


def test_what_fell_out_of_the_hand_is_lost(watch):
    watch.watch(seen(0.1, 0.05))
    watch.watch(seen(0.2, 0.03, touching=()))
    assert not watch.over and watch.merit == 0.0
    watch.watch(seen(0.3, 0.0, touching={"table"}))
    assert watch.outcome == "lost" and watch.lift_height == pytest.approx(0.05)


def test_what_rolled_off_the_table_is_lost(watch):
    watch.watch(seen(0.1, -0.06, touching=()))
    assert watch.outcome == "lost" and watch.reason == "fell off the table"


def test_a_lift_with_the_table_s_help_does_not_count(watch):
    watch.watch(seen(0.1, 0.12, touching={*HAND, "table"}))
    assert watch.merit == 0.0 and watch.hold_time == 0.0
