"""Shape adaptability of a hold against closed forms and against a convex hull."""

from itertools import pairwise

import numpy as np
import pytest
from scipy.spatial import ConvexHull

from grasp_strategies.judging.adaptability import (
    CONE_EDGES,
    TouchPoint,
    adaptability,
    closure_margin,
    edge_wrenches,
    resisted,
)

RADIUS, LENGTH, FRICTION, PATCH = 0.02, 0.04, 0.6, 0.003
CONE = 1.0 - np.cos(np.pi / CONE_EDGES)  # largest error of a pyramid within the cone
CENTRE = np.zeros(3)


def around(angles, patch=0.0, friction=FRICTION):
    """Contacts of parts of their own on a circle in x and y [rad], pressing towards its middle."""
    places = [np.array([np.cos(a), np.sin(a), 0.0]) for a in np.radians(angles)]
    return [
        TouchPoint(f"finger{k}", "tip", tuple(RADIUS * p), tuple(-p), friction, patch)
        for k, p in enumerate(places)
    ]


def most(touches, *direction):
    return resisted(edge_wrenches(touches, CENTRE, LENGTH), np.array(direction, float))


# ---------------------------------------------------------------- closed forms
def test_two_opposed_soft_contacts_resist_what_their_friction_allows():
    """Each presses with 0.5 N: sideways force mu, torque across mu r, twist 3 pi/16 mu a."""
    pinch = around([0.0, 180.0], PATCH)
    assert most(pinch, 1, 0, 0, 0, 0, 0) == pytest.approx(1.0)  # along it one presses alone
    assert most(pinch, 0, 0, 1, 0, 0, 0) == pytest.approx(FRICTION, rel=CONE)
    assert most(pinch, 0, 0, 0, 0, 1, 0) == pytest.approx(FRICTION * RADIUS / LENGTH, rel=CONE)
    twist = 3.0 * np.pi / 16.0 * FRICTION * PATCH / LENGTH
    assert most(pinch, 0, 0, 0, 1, 0, 0) == pytest.approx(twist, rel=1e-6)
    found = adaptability(pinch, CENTRE, LENGTH)
    assert found.force_closed and found.margin == pytest.approx(twist, rel=1e-6)
    assert (found.links, found.parts, found.redundancy) == (2, 2, 8 - 6)
    assert found.area == pytest.approx(2.0 * np.pi * PATCH**2)


def test_two_hard_points_let_the_object_turn_about_their_line():
    found = adaptability(around([0.0, 180.0]), CENTRE, LENGTH)
    assert not found.force_closed and found.margin == 0.0
    assert found.redundancy == 6 - 5 and found.area == 0.0


def test_three_hard_points_with_friction_are_force_closed():
    """By symmetry each presses with a third of 1 N against a push or a turn across the plane."""
    tripod = around([0.0, 120.0, 240.0])
    assert most(tripod, 0, 0, 1, 0, 0, 0) == pytest.approx(FRICTION, rel=CONE)
    assert most(tripod, 0, 0, 0, 0, 0, 1) == pytest.approx(FRICTION * RADIUS / LENGTH, rel=CONE)
    found = adaptability(tripod, CENTRE, LENGTH)
    assert found.force_closed and found.redundancy == 9 - 6


@pytest.mark.parametrize(
    "touches",
    [
        around([0.0, 40.0, -40.0], PATCH),  # every force in a cone pushes away from them
        around([0.0, 120.0, 240.0], friction=1e-9),  # no friction: free along the axis
        around([0.0, 90.0], PATCH, friction=0.5),  # Nguyen: the line is outside both cones
        around([0.0], PATCH),
        [],
    ],
    ids=["one side", "no friction", "line outside the cones", "one contact", "none"],
)
def test_what_lets_the_object_go_is_not_force_closed(touches):
    assert adaptability(touches, CENTRE, LENGTH).margin == 0.0


def test_two_contacts_close_where_their_line_lies_in_both_cones():
    """Nguyen (1988): at 180 deg - 2*b the line leans by b, inside the cone for tan(b) < mu."""
    lean = np.degrees(np.arctan(FRICTION))
    inside, outside = (around([0.0, 180.0 - 2.0 * f * lean], PATCH) for f in (0.9, 1.1))
    assert adaptability(inside, CENTRE, LENGTH).force_closed
    assert not adaptability(outside, CENTRE, LENGTH).force_closed


# ---------------------------------------------------------------- another solver
def random_touches(seed, count):
    """Contacts on a ball, half of the time with patches."""
    rng = np.random.default_rng(seed)
    places = rng.normal(size=(count, 3))
    places /= np.linalg.norm(places, axis=1, keepdims=True)
    return [
        TouchPoint(str(k), "", tuple(RADIUS * p), tuple(-p), 0.5, PATCH * (k % 2))
        for k, p in enumerate(places)
    ]


@pytest.mark.parametrize("seed", range(4))
def test_margin_is_the_distance_to_the_hull_of_the_wrenches(seed):
    """Along each direction to the nearest face, by qhull."""
    wrenches = edge_wrenches(random_touches(seed, 4), CENTRE, LENGTH)
    faces = ConvexHull(wrenches.T).equations
    inside = bool((faces[:, -1] < -1e-9).all())
    along = np.abs(faces[:, :6])  # both ways of each axis
    expected = float((-faces[:, -1:] / np.maximum(along, 1e-12)).min()) if inside else 0.0
    assert closure_margin(wrenches) == pytest.approx(expected, abs=1e-6)


@pytest.mark.parametrize("seed", range(3))
def test_a_further_contact_never_lowers_what_is_resisted(seed):
    """The thesis, 8.1: contacts improve force closure or add redundancy."""
    touches = random_touches(seed, 9)
    found = [adaptability(touches[:count], CENTRE, LENGTH) for count in range(2, 10)]
    for before, after in pairwise(found):
        assert after.margin >= before.margin - 1e-9
        assert after.redundancy >= before.redundancy
    assert found[-1].force_closed


# ---------------------------------------------------------------- counts
def test_points_of_a_link_count_as_one_link():
    """Two points of a link in one place can do no more than one of them."""
    pinch = around([0.0, 180.0], PATCH)
    once, twice = (adaptability(pinch * count, CENTRE, LENGTH) for count in (1, 2))
    assert (once.points, twice.points) == (2, 4)
    assert once.links == twice.links == 2 and once.redundancy == twice.redundancy
    assert twice.margin == pytest.approx(once.margin)


def test_torques_are_divided_by_the_length():
    pinch = around([0.0, 180.0], PATCH)
    short, long = (adaptability(pinch, CENTRE, length).margin for length in (LENGTH, 2 * LENGTH))
    assert short == pytest.approx(2.0 * long)
    with pytest.raises(ValueError, match=r"length: expected a positive number \[m\], got 0"):
        adaptability(pinch, CENTRE, 0.0)
