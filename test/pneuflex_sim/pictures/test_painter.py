"""Pictures by matplotlib against those of PyBullet's renderer: the same silhouette."""

import numpy as np
import pytest

from pneuflex_sim.pictures import render
from pneuflex_sim.pictures.painter import paint, project
from pneuflex_sim.pictures.render import Camera, HandState, Renderer

UPRIGHT = np.array([0.0, 0.0, 0.0, 1.0])
SIZE = (320, 240)
RED, BLUE = (1.0, 0.0, 0.0, 1.0), (0.0, 0.0, 1.0, 1.0)
VIEWS = [Camera(), Camera(yaw=-62.0, pitch=-16.0), Camera((0.02, 0.01, 0.12), 0.4, 100.0, 25.0)]


def silhouette(picture):
    """Where something is drawn on the white ground."""
    return picture.min(axis=2) < 250


@pytest.mark.parametrize("camera", VIEWS)
@pytest.mark.parametrize("thing", ["tube", "ball", "tape_dispenser"])
def test_hand_and_object_cover_the_same_pixels_as_by_pybullet(monkeypatch, camera, thing):
    renderer = Renderer("rbo_hand_2", thing, "stand", 3)
    place, turn = np.array([0.03, -0.02, 0.02]), np.array([0.5, 0.5, 0.5, 0.5])
    wrist = np.array([0.0, 0.0, 0.05])
    state = HandState(renderer.layout.rest.copy(), wrist, UPRIGHT, place, turn)
    expected = silhouette(renderer.frame(state, SIZE, camera))
    monkeypatch.setattr(render, "is_installed", lambda: False)
    monkeypatch.setattr(render.pybullet, "connect", lambda *_: pytest.fail("by PyBullet"))
    painted = renderer.frame(state, SIZE, camera)
    found = silhouette(painted)
    assert painted.shape == (SIZE[1], SIZE[0], 3)
    assert expected.mean() > 0.02
    assert (found & expected).sum() / (found | expected).sum() > 0.9


@pytest.mark.parametrize("first", [-0.1, 0.1])
def test_what_is_nearer_covers_what_is_farther(first):
    triangle = np.array([[[-0.1, 0.0, -0.1], [0.1, 0.0, -0.1], [0.0, 0.0, 0.1]]])  # faces it
    shown = [(triangle + [0.0, y, 0.0], color) for y, color in ((first, RED), (-first, BLUE))]
    picture = paint([], shown, Camera((0.0, 0.0, 0.0), 0.5, 0.0, 0.0), SIZE)
    red, _, blue = picture[SIZE[1] // 2, SIZE[0] // 2].astype(int)
    assert bool(red > blue + 100) is (first < 0.0)  # the camera looks along y
    assert bool(blue > red + 100) is (first > 0.0)


def test_the_target_is_in_the_middle_and_a_point_to_the_right_is_right_of_it():
    camera = Camera((0.1, 0.2, 0.3), 0.5, 0.0, 0.0, 90.0)
    places, depth = project(np.array([[0.1, 0.2, 0.3], [0.2, 0.2, 0.3]]), camera, (200, 100))
    assert places == pytest.approx(np.array([[100.0, 50.0], [100.0 + 50.0 * 0.1 / 0.5, 50.0]]))
    assert depth == pytest.approx(0.5)
