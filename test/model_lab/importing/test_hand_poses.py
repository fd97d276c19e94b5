"""Bags of hands that hold poses, as sets of `hand_pose`."""

from itertools import pairwise

import numpy as np
import pytest
from hand_bag import CHANNELS, FIST, OPEN, PALM_DOWN, PALM_UP, POINT, place_of, recorded

from model_lab.api.data import import_files
from model_lab.importing.hand_courses import HandCourse
from model_lab.importing.hand_poses import held_poses
from model_lab.importing.hand_sets import set_of_hand
from softhand_common.documents.yaml_document import DocumentError
from softhand_common.numerics.rotations import from_rpy

TWICE = [(p, rpy) for rpy in (PALM_UP, PALM_DOWN) for p in (OPEN, FIST, POINT, OPEN, FIST, POINT)]


def of_bag(bag, hand="rbo_hand_2"):
    found, _ = set_of_hand([bag], hand)
    return found


@pytest.mark.parametrize("segments", [5, 12])
def test_the_joints_of_a_simulated_hand_tell_its_segments(tmp_path, segments):
    joints = [f"thumb_{k}_{axis}" for k in range(segments) for axis in "xyz"]
    joints += [f"index_{k}_{axis}" for k in range(segments + 1) for axis in "xyz"]  # with a strut
    bag = recorded(tmp_path / "bag", TWICE, joints=joints)
    entry = of_bag(bag).document["specimens"]["hand"]
    assert entry == {"hand": "rbo_hand_2", "segments": segments}


def test_a_real_hand_has_no_segments(tmp_path):
    entry = of_bag(recorded(tmp_path / "bag", TWICE)).document["specimens"]
    assert entry["hand"] == {"hand": "rbo_hand_2"}


def test_poses_become_runs_that_end_where_the_wrist_turns_or_the_hand_is_empty(tmp_path):
    found = of_bag(recorded(tmp_path / "bag", TWICE))
    entries = found.document["runs"]
    assert [entry["protocol"] for entry in entries.values()] == [
        "poses_1", "poses_1", "poses_2", "poses_2",
    ]  # fmt: skip
    assert np.allclose(from_rpy(entries["r3"]["wrist_rpy"]), from_rpy(PALM_DOWN), atol=1e-5)
    for run in found.runs:
        for index, pressures in enumerate((OPEN, FIST, POINT)):
            told = [run.columns[f"pressure.{channel}"][index] for channel in CHANNELS]
            assert np.allclose(told, 1e-3 * np.array(pressures), atol=0.3)
            for tip, name in enumerate(("thumb", "index", "middle", "ring", "little")):
                told = [run.columns[f"{name}_tip.{axis}"][index] for axis in "xyz"]
                right = 1e3 * place_of(tip, pressures, PALM_UP if run.name < "r3" else PALM_DOWN)
                assert np.allclose(told, right, atol=0.3)


def test_what_was_imported_is_a_set_that_the_lab_reads(tmp_path):
    data = import_files([recorded(tmp_path / "bag", TWICE)], hand="rbo_hand_2")
    assert str(data).count("protocol poses_") == 4
    assert "touched nothing" in str(data)


def test_poses_in_which_the_wrist_bears_more_than_the_hand_are_told(tmp_path):
    forces = [0.0, 0.1, -0.8, 0.0, 0.0, 0.0, *6 * [0.15]]
    told = of_bag(recorded(tmp_path / "touching", TWICE, forces=forces)).remarks[0]
    assert "in r1 at 3.35 s (0.8 N):" in told  # the third pose of the first run
    assert "r2" not in told
    for name, felt in (("air", 12 * [0.15]), ("unknown", ())):
        remarks = of_bag(recorded(tmp_path / name, TWICE, forces=felt)).remarks
        assert not any("bore more" in remark for remark in remarks)


def test_a_finger_of_the_hand_is_still_measured_as_a_finger(tmp_path):
    bag = recorded(tmp_path / "bag", TWICE[:2])
    assert set_of_hand([bag], "rbo_hand_2") is not None
    for hand in ("rbo_hand_2:index", "single_finger", None):
        assert set_of_hand([bag], hand) is None
    assert set_of_hand([bag], "rbo_hand_2", "free_bending") is None


def test_another_hand_is_refused(tmp_path):
    bag = recorded(tmp_path / "bag", TWICE[:2])
    with pytest.raises(DocumentError, match="expected 3 fingertips of rbo_hand_1, got 5"):
        of_bag(bag, "rbo_hand_1")


def test_a_hand_that_never_rests_is_refused(tmp_path):
    bag = recorded(tmp_path / "bag", TWICE, hold=0.1, move=1.0)
    with pytest.raises(DocumentError, match="at least two poses, each held for 0.8 s, got none"):
        of_bag(bag)


@pytest.mark.parametrize("noise", [0.0, 1.2e-3, 3e-3])
def test_noise_of_the_markers_neither_hides_nor_splits_a_pose(noise):
    rate, held, passing, poses, tips = 50, 80, 30, 7, 4  # [Hz], samples
    random = np.random.default_rng(4)
    turns = np.linspace(0.0, 1.0, poses)
    course = np.concatenate(
        [
            np.repeat(turns[:1], held),
            *(
                [*np.linspace(one, other, passing), *np.repeat(other, held)]
                for one, other in pairwise(turns)
            ),
        ]
    )
    ways = random.standard_normal((tips, 3))
    ways *= 0.09 / np.linalg.norm(ways, axis=1)[:, None]  # [m]
    time = np.arange(len(course)) / rate
    places = {
        str(tip): course[:, None] * way + noise * random.standard_normal((len(course), 3))
        for tip, way in enumerate(ways)
    }
    wrist = np.tile([0.0, 0.0, 0.0, 1.0], (len(course), 1))
    found = held_poses(HandCourse((), time, 30e3 * course[:, None], places, wrist))
    assert len(found) == poses
    error = [pose.places - turn * ways for pose, turn in zip(found, turns, strict=True)]
    assert np.std(error) < 0.3e-3 + noise / 5.0
