"""The picture of a hand is to scale, in the colours of its channels."""

from pathlib import Path

import numpy as np
import pytest
from matplotlib.colors import to_rgb

from pneuflex_sim.hand.layout import build_layout
from pneuflex_sim.pictures.hand_picture import channel_colors, draw_hand
from softhand_model.hand.hand import load_hand
from softhand_model.model_file import Model

GRIPPER = Path(__file__).parents[3] / "examples/three_finger_gripper/gripper.yaml"


def drawn_at_rest(name):
    """Hand, and the axes (from the palm, from the side) of its picture at rest."""
    hand = load_hand(name)
    rest = np.asarray(build_layout(hand, 3, Model()).rest)
    figure = draw_hand(hand, [np.zeros(len(hand.channels))], [rest], 3)
    return hand, figure.axes


def reach(axes, color):
    """Least and greatest coordinate [mm] across and along, of pixels of a hue, light or dark."""
    (image,) = axes.images
    picture, (left, right, bottom, top) = np.asarray(image.get_array()) / 255.0, image.get_extent()
    hue = np.array(to_rgb(color))
    shade = picture @ hue / (hue @ hue)
    rows, columns = np.nonzero(
        np.abs(picture - shade[..., None] * hue).max(axis=-1) < 0.06 * (shade < 1.1)
    )
    height, width = picture.shape[:2]
    across = left + (np.array([columns.min(), columns.max() + 1]) / width) * (right - left)
    along = top - (np.array([rows.max() + 1, rows.min()]) / height) * (top - bottom)
    return sorted(across), along


def test_a_finger_has_its_length_width_and_height_in_mm():
    hand, (palm, side) = drawn_at_rest("single_finger")
    color = channel_colors(hand)["a"]
    # perspective from 4 m, and a pixel of 0.33 mm
    (left, right), (_, top) = reach(palm, color)
    assert top == pytest.approx(90.0, abs=1.0)
    assert (left, right) == pytest.approx((-10.0, 10.0), abs=0.6)
    (back, front), _ = reach(side, color)
    assert (back, front) == pytest.approx((-20.0, 0.0), abs=0.6)


def test_dimensions_are_written_beside_the_picture():
    _, (palm, side) = drawn_at_rest("single_finger")
    # finger of 90 mm on a plate of 30 x 30 x 10 mm below it
    assert [text.get_text() for text in palm.texts if text.get_text()] == ["30", "100"]
    assert [text.get_text() for text in side.texts if text.get_text()] == ["30", "100"]


def test_each_channel_has_its_colour_where_its_fingers_are():
    hand, (palm, side) = drawn_at_rest(GRIPPER)
    colors = channel_colors(hand)
    assert len(set(colors.values())) == 2
    (left, right), _ = reach(palm, colors["single"])
    assert (left, right) == pytest.approx((-10.0, 10.0), abs=0.6)  # the broad finger in front
    (back, front), _ = reach(side, colors["single"])
    assert (back, front) == pytest.approx((40.0, 59.0), abs=1.2)
    (left, right), _ = reach(palm, colors["pair"])
    assert right == pytest.approx(-left, abs=0.6)
    assert right > 45.0
