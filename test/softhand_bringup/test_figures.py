"""The figures show what is in the bag; what they look like is looked at, not tested."""

import json
import subprocess
import sys
from itertools import pairwise

import matplotlib.pyplot as plt
import numpy as np
import pytest

from softhand_bringup import figures
from softhand_bringup.bags.reading import Bag


@pytest.fixture
def drawn(grasp_bag, tmp_path, monkeypatch):
    """The axes of grasp.png, kept from being closed."""
    kept = []
    monkeypatch.setattr(plt, "close", kept.append)
    with Bag(grasp_bag) as bag:
        figures.draw_grasp(bag, tmp_path / "grasp.png")
    assert (tmp_path / "grasp.png").stat().st_size > 10_000
    yield kept[0].axes
    monkeypatch.undo()
    plt.close(kept[0])


def curves(axis):
    return [np.column_stack(line.get_data()) for line in axis.get_lines()]


def test_air_is_drawn_in_milligrams_commanded_beside_contained(drawn):
    commanded, contained = curves(drawn[0])
    assert commanded[-1] == pytest.approx([4.0, 20.0])
    assert contained[75] == pytest.approx([1.5, 10.0])


def test_pressure_is_drawn_in_kilopascal_and_height_in_millimetres_above_the_start(drawn):
    assert curves(drawn[1])[0][-1] == pytest.approx([4.0, 20.0])
    assert curves(drawn[2])[0][[0, -1], 1] == pytest.approx([0.0, 100.0])


def test_phases_are_named_without_the_idle_before_the_call(drawn):
    assert [text.get_text() for text in drawn[0].texts] == ["close", "lift"]


def test_pictures_are_taken_at_the_ends_of_phases_and_in_the_longest_gaps():
    marks = [figures.Phase("a", 0.0, 1.0), figures.Phase("b", 1.0, 9.0)]
    times = figures.frame_times(marks, 9.0, 8)
    assert len(times) == 8
    assert {1.0, 9.0} <= set(times)
    assert np.diff(times).max() <= 2.0


def test_with_many_phases_the_shortest_has_no_picture():
    ends = [0.0, 1.0, 2.0, 2.1, 3.0, 4.0]
    marks = [figures.Phase(str(end), start, end) for start, end in pairwise(ends)]
    assert figures.frame_times(marks, 4.0, 4).tolist() == [1.0, 2.0, 3.0, 4.0]


def test_a_bag_without_the_object_is_refused_by_topic(grasp_bag, tmp_path, monkeypatch):
    monkeypatch.setattr(figures, "OBJECT_TOPIC", "/scene/nothing")
    with Bag(grasp_bag) as bag, pytest.raises(ValueError, match="/scene/nothing"):
        figures.draw_grasp(bag, tmp_path / "grasp.png")


def test_pictures_of_a_lift_look_at_its_middle_from_where_it_began():
    path = np.array([[0.1, 0.2, 0.0], [0.3, 0.4, 0.1]])
    assert figures._centre(path) == pytest.approx((0.1, 0.2, 0.09))
    assert figures._middle(path, 0.1) == pytest.approx((0.2, 0.3, 0.15))


def test_a_bag_that_is_not_there_is_said(tmp_path, capsys):
    assert figures.main([str(tmp_path / "none"), str(tmp_path / "new")]) == 1
    assert "figures: " in capsys.readouterr().err


WITHOUT_PYBULLET = """
import sys
sys.modules["pybullet"] = None
from softhand_bringup.figures import main
from softhand_trials import trials
assert trials.main(["--seeds", "1", "--step", "0.01", "--out", sys.argv[2] + "/trial.json"]) == 0
assert trials.main(["--engine", "pybullet"]) == 2
sys.exit(main([*sys.argv[1:], "--hand", "single_finger"]))
"""


def test_trials_run_and_a_demo_is_drawn_where_pybullet_cannot_be_imported(grasp_bag, tmp_path):
    words = [sys.executable, "-c", WITHOUT_PYBULLET, str(grasp_bag), str(tmp_path)]
    run = subprocess.run(words, capture_output=True, text=True, timeout=600)
    assert run.returncode == 0, run.stderr
    assert "pybullet: expected it to be installed, got none" in run.stderr
    trial = json.loads((tmp_path / "trial.json").read_text())
    assert (trial["settings"]["engine"], trial["gripped"]) == ("mujoco", 1)
    shown = plt.imread(tmp_path / "frames.png")[..., :3]
    assert (shown.max(axis=2) - shown.min(axis=2) > 0.3).mean() > 0.005  # the finger's rubber
