"""What counts as sliding of an object on what touches it."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from thesis.chapter_3_and_5.held_cylinder import HeldCylinder
from thesis.chapter_3_and_5.payload import GRASPS, JUDGED_HAND
from thesis.chapter_3_and_5.slip import SlipMeter, Touching, slid

RADIUS, TURN, WAY = 0.03, 1e-3, 2e-3  # [m, rad, m]


def ball_on_a_plane(count=2):
    """A ball on a part whose frame is elsewhere; both contacts are beneath it."""
    return Touching(
        np.zeros((count, 3)),
        np.tile([0.0, 0.0, 1.0], (count, 1)),
        np.ones(count),
        np.array([0.0, 0.0, RADIUS]),
        np.eye(3),
        np.tile([0.1, 0.0, -0.1], (count, 1)),
        np.tile(np.eye(3), (count, 1, 1)),
    )


def after(shift, turn=(0.0, 0.0, 0.0)):
    return np.array([0.0, 0.0, RADIUS]) + shift, Rotation.from_rotvec(turn).as_matrix()


STILL = (ball_on_a_plane().part_place, ball_on_a_plane().part_axes)


@pytest.mark.parametrize(
    ("shift", "turn", "expected"),
    [
        ([WAY, 0.0, 0.0], [0.0, 0.0, 0.0], WAY),
        ([0.0, 0.0, WAY], [0.0, 0.0, 0.0], 0.0),  # lifted
        ([RADIUS * TURN, 0.0, 0.0], [0.0, TURN, 0.0], 0.0),  # rolled
        ([0.0, 0.0, 0.0], [0.0, TURN, 0.0], RADIUS * TURN),  # spun on the spot
    ],
)
def test_only_what_moves_along_the_surface_counts(shift, turn, expected):
    found = slid(ball_on_a_plane(), after(np.array(shift), turn), STILL)
    assert found == pytest.approx(expected, abs=1e-8)


def test_what_moves_with_its_part_does_not_slide():
    turn = Rotation.from_rotvec([0.0, 0.2, 0.1])
    touching = ball_on_a_plane()
    moved = (
        turn.apply(touching.object_place) + [WAY, 0.0, 0.0],
        turn.as_matrix(),
    )
    parts = (
        turn.apply(touching.part_place) + [WAY, 0.0, 0.0],
        np.tile(turn.as_matrix(), (2, 1, 1)),
    )
    assert slid(touching, moved, parts) == pytest.approx(0.0, abs=1e-12)


def test_what_touches_nothing_does_not_slide():
    assert slid(ball_on_a_plane(0), after(np.ones(3)), STILL) == 0.0


def test_a_cylinder_gives_way_with_a_soft_hand_before_it_slides():
    """A pull that creeps up to 3 N along the fingers: most of the way is the hand's."""
    with HeldCylinder(GRASPS[JUDGED_HAND]) as held:
        start, meter = held.place, SlipMeter(held.simulation)
        for k in range(375):
            held.load(np.array([0.0, 0.0, 8e-3 * (k + 1)]))
            if k % 5 == 4:
                meter.look()
        way = np.linalg.norm(held.place - start)
    assert 0.001 < way < 0.010
    assert meter.way < 0.3 * way
