"""Tip angles of tracked things, against motions of which the angle is known."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from model_lab.importing import derived

ANGLE = np.radians(np.concatenate([np.linspace(0.0, 230.0, 60), np.linspace(230.0, 10.0, 40)]))
TURN = Rotation.from_euler("xyz", [0.4, -0.7, 1.1])  # of the tracker's frame


def arc(angle, share=1.0, length=90.0):
    """Positions (3, samples) on arcs of some angles, seen in the tracker's frame."""
    safe = np.where(np.abs(angle) < 1e-9, 1e-9, angle)
    along, radius = share * safe, length / safe
    plane = [radius * np.sin(along), radius * (1.0 - np.cos(along)), np.zeros_like(along)]
    return TURN.apply(np.transpose(plane)).T


@pytest.mark.parametrize("axis", [[0, 0, 1], [0, 1, 0], [0.6, -0.64, 0.48]])
def test_a_quaternion_of_any_sign_gives_the_turn_about_its_axis_beyond_half_a_turn(axis):
    start = Rotation.from_euler("xyz", [0.3, 1.0, -2.0])
    quaternion = (start * Rotation.from_rotvec(np.outer(ANGLE, axis))).as_quat().T
    quaternion[:, ::3] *= -2.0
    np.testing.assert_allclose(derived.quaternion_angle(quaternion), ANGLE, atol=1e-9)


def test_one_component_is_far_from_the_angle():
    quaternion = Rotation.from_rotvec(np.outer(ANGLE, [0, 1, 0])).as_quat().T
    assert np.abs(quaternion[1] - ANGLE).max() > 1.0


def test_two_markers_on_the_tip_turn_as_it_does():
    direction = TURN.apply(np.transpose([np.cos(ANGLE), np.sin(ANGLE), 0.0 * ANGLE])).T
    first = arc(ANGLE)
    found = derived.markers_angle(np.concatenate([first, first + 8.0 * direction]))
    np.testing.assert_allclose(found, ANGLE, atol=1e-9)
    flat = np.stack([0.0 * ANGLE, 0.0 * ANGLE, np.cos(-ANGLE), np.sin(-ANGLE)])
    np.testing.assert_allclose(derived.markers_angle(flat), ANGLE, atol=1e-9)


@pytest.mark.parametrize("middle", [0.3, 0.5])
def test_three_markers_lie_on_an_arc(middle):
    positions = np.concatenate([0.0 * arc(ANGLE), arc(ANGLE, middle), arc(ANGLE)])
    np.testing.assert_allclose(derived.markers_angle(positions), ANGLE, atol=1e-6)


def test_the_chord_of_an_arc_turns_half_as_far_as_its_tip():
    np.testing.assert_allclose(derived.tip_angle(arc(ANGLE)), ANGLE, atol=1e-6)
    np.testing.assert_allclose(derived.chord_angle(ANGLE[None] / 2.0 + 0.1), ANGLE, atol=1e-9)


def test_an_arc_bends_by_its_length_times_its_curvature():
    bend = ANGLE + 0.1  # a rest curvature is not bend
    curvature = bend / 0.09
    np.testing.assert_allclose(derived.curvature_angle(0.09 * curvature[None]), ANGLE, atol=1e-9)
    radius = 1.0 / curvature
    np.testing.assert_allclose(derived.radius_angle(radius[None] / 0.09), ANGLE, atol=1e-9)


@pytest.mark.parametrize("name", ["kappa", "Krümmung", "curvature [1/m]", "courbure"])
def test_a_curvature_is_proposed_with_the_length_that_it_needs(name):
    assert derived.suggestion(["t", "p", name]) == f"curvature({name},LENGTH)"
