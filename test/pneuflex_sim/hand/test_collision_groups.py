"""Which chains of a hand meet which."""

from itertools import combinations
from pathlib import Path

import pytest

from pneuflex_sim.hand.collision import collides_with, collision_groups
from pneuflex_sim.hand.layout import build_layout
from softhand_model.hand.hand import load_hand
from softhand_model.model_file import Model

GRIPPER = Path(__file__).parents[3] / "examples/three_finger_gripper/gripper.yaml"


def groups_of(hand):
    """Collision group by chain."""
    layout = build_layout(load_hand(hand), 3, Model())
    found = {}
    for body in layout.bodies:
        groups = collision_groups(layout, body)
        for chain in body.chains:
            joints = layout.chain_joints[chain]
            own = set(groups[joints.start - body.joints.start : joints.stop - body.joints.start])
            (found[chain],) = own
    return found


def meeting(hand):
    """Pairs of chains that meet, by the rule of Bullet: each is in the other's mask."""
    groups = groups_of(hand)
    return {
        frozenset((one, other))
        for one, other in combinations(groups, 2)
        if groups[one] & collides_with(groups[other]) and groups[other] & collides_with(groups[one])
    }


def test_in_rbo_hand_2_the_thumb_meets_every_finger_and_nothing_else_meets():
    fingers = ("index", "middle", "ring", "little")
    assert meeting("rbo_hand_2") == {frozenset(("thumb", finger)) for finger in fingers}


@pytest.mark.parametrize("hand", ["rbo_hand_1", "rbo_hand_1_split", "single_finger"])
def test_fingers_side_by_side_do_not_meet(hand):
    assert meeting(hand) == set()


def test_fingers_that_face_each_other_meet():
    fingers = ("front", "left", "right")
    assert meeting(GRIPPER) == {frozenset(pair) for pair in combinations(fingers, 2)}


def test_all_chains_meet_objects():
    assert all(collides_with(group) & 1 for group in groups_of("rbo_hand_2").values())
