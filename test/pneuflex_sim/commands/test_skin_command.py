"""The command that writes a closing hand."""

import matplotlib.image
import numpy as np
import pytest

from pneuflex_sim.commands.skin import main, pressures
from softhand_model.hand.hand import load_hand


def run(*arguments):
    return main([str(argument) for argument in arguments])


def heights(path):
    """z [m] of all vertices of an OBJ file."""
    lines = path.read_text().splitlines()
    return np.array([float(line.split()[3]) for line in lines if line.startswith("v ")])


def test_a_closing_finger_is_written_frame_by_frame(tmp_path):
    out = ("--out", tmp_path)
    assert run("single_finger", "--pressure", 20e3, "--frames", 3, "--segments", 4, *out) == 0
    tops = [heights(tmp_path / f"single_finger_{k:03d}.obj").max() for k in range(3)]
    assert tops[0] == pytest.approx(0.090, abs=1e-6)
    assert tops[0] > tops[1] > tops[2]
    assert run("single_finger", "--frames", 3, *out) == 2


def test_a_figure_shows_open_and_closed(tmp_path):
    path = tmp_path / "finger.png"
    assert run("single_finger", "--pressure", 20e3, "--segments", 3, "--figure", path) == 0
    assert run("single_finger", "--segments", 3, "--figure", path) == 2  # it exists
    picture = matplotlib.image.imread(path)[..., :3]
    halves = np.split(picture, 2, axis=1)
    assert picture.std() > 0.02
    assert np.abs(halves[0] - halves[1]).max() > 0.2


def test_pressures_are_one_a_channel_or_one_for_all():
    hand = load_hand("rbo_hand_2")
    assert pressures(hand, [3e4]).tolist() == [3e4] * 4
    assert pressures(hand, [1e4, 2e4, 3e4, 4e4]).tolist() == [1e4, 2e4, 3e4, 4e4]
    assert pressures(hand, None) == pytest.approx(0.4 * hand.max_pressures())


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("claw",), "hand: expected one of rbo_hand_1"),
        (("rbo_hand_2", "--pressure", "1e4", "1e4"), "pressure: expected 1 or 4 numbers, got 2"),
        (("rbo_hand_2", "--pressure", "9e9"), "pressure: expected 0 to"),
        (("single_finger", "--frames", "1"), "frames: expected 2 or more, got 1"),
    ],
)
def test_what_cannot_be_used_is_refused(arguments, words, tmp_path, capsys):
    assert run(*arguments, "--out", tmp_path) == 2
    assert words in capsys.readouterr().err
