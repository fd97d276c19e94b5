"""The simulated finger against PyElastica, a simulator of rods by other people.

Its kernels are compiled the first time, which takes a minute or two; after that it is seconds.
"""

import cosserat
import elastica_finger
import numpy as np
import pytest

from softhand_model.hand.actuator import load_actuator
from thesis.chapter_3_and_5.stand import FingerStand

FINGER = load_actuator("P10.finger")
PRESSURE, GAP = 40e3, 0.015  # [Pa, m]


def of_length(one, other):
    return np.linalg.norm(np.subtract(one, other)) / FINGER.length


def test_free_finger_ends_where_that_of_pyelastica_does():
    with FingerStand(FINGER, 10) as stand:
        stand.settle(PRESSURE)
        tip = stand.line()[-1, [0, 2]]
    rested = elastica_finger.rest(cosserat.rod_of(FINGER, PRESSURE))
    assert rested.speed < 1e-4
    assert of_length(tip, rested.tip) < 0.01


def test_blocked_finger_pushes_as_that_of_pyelastica_does():
    with FingerStand(FINGER, 10) as stand:
        block = stand.block(GAP, 0.07)
        stand.settle(PRESSURE)
        touch, tip = stand.touch(block), stand.line()[-1, [0, 2]]
    rested = elastica_finger.rest(cosserat.rod_of(FINGER, PRESSURE), GAP)
    assert rested.speed < 1e-4
    assert touch.force == pytest.approx(rested.tip_force, rel=0.01)
    assert of_length(tip, rested.tip) < 0.01
