"""Films of grasps: pace, sizes, formats, and that filming changes nothing."""

import json
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from PIL import Image

from pneuflex_sim.pictures.render import Camera
from softhand_bringup.film import command, writing
from softhand_bringup.film.recording import film_bag, film_trial
from softhand_trials.sweep import TrialTask
from softhand_trials.trials import Placement, TrialSettings, draw_placement, run_trial

SHORT = """
format: softhand-strategy/1
name: short
description: close a little in the air
hand: single_finger
phases:
  - name: close
    air_mass: {a: 1.0e-5}
    duration: 0.5
  - name: hold
    duration: 0.3
"""
QUICK = ["--step", "0.005", "--segments", "3", "--size", "64x48"]


def placed(seed, settings):
    """The placement that a batch draws."""
    return Placement(*draw_placement(seed, settings.offset, settings.mass_spread))


@pytest.fixture
def settings(tmp_path):
    path = tmp_path / "short.yaml"
    path.write_text(SHORT)
    return TrialSettings(strategy=str(path), step=0.005, segments=3)


@pytest.fixture
def film(settings, tmp_path):
    """Run the command on the short strategy; returns its status and path."""

    def run(name, *options):
        path = tmp_path / name
        given = ["-o", str(path), "--strategy", settings.strategy, *QUICK, *options]
        return command.main(given), path

    return run


def played(path):
    """Pictures of a GIF and how long it plays [s]."""
    with Image.open(path) as image:
        frames, length = [], 0.0
        for k in range(image.n_frames):
            image.seek(k)
            frames.append(np.asarray(image.convert("RGB")))
            length += 1e-3 * image.info["duration"]
    return frames, length


def test_states_lie_at_even_times_from_the_start_to_the_end_of_the_trial(settings):
    recording = film_trial(settings, placed(0, settings), 0.1)
    assert len(recording.states) == 9
    fine = film_trial(settings, placed(0, settings), 0.005)
    for k, state in enumerate(recording.states):
        np.testing.assert_array_equal(state.joints, fine.states[20 * k].joints)
    moved = [np.abs(a.joints - b.joints).max() for a, b in pairwise(fine.states)]
    assert sum(moved) > 0.01


def test_a_trial_that_is_filmed_ends_as_the_same_trial_of_a_batch(settings):
    recording, trial = film_trial(settings, placed(4, settings), 0.05), run_trial(4, settings)
    assert recording.ending == f"{trial.result.outcome}: {trial.result.reason}"
    place = recording.states[0].object_position
    np.testing.assert_allclose(place[:2], trial.offset, atol=1e-12)


def test_an_offset_replaces_the_drawn_one(settings):
    recording = film_trial(settings, replace(placed(4, settings), offset=(0.0, 0.0)), 0.4)
    np.testing.assert_allclose(recording.states[0].object_position[:2], 0.0, atol=1e-12)


def test_a_second_of_film_is_a_second_of_simulation_and_slow_motion_is_longer(film):
    status, path = film("film.gif", "--fps", "10")
    frames, length = played(path)
    assert status == 0
    assert length == pytest.approx(0.9)  # nine pictures, from 0.0 to 0.8 s
    assert frames[0].shape == (48, 64, 3)
    assert any(np.abs(frames[0].astype(int) - frame).max() > 60 for frame in frames)
    assert played(film("slow.gif", "--fps", "10", "--slow", "2")[1])[1] == pytest.approx(1.7)


def test_actuators_redden_with_their_pressure_where_that_is_asked_for(film):
    def green_of_the_finger(path):
        last = played(path)[0][-1].astype(int)
        return last[(last[:, :, 0] > 1.2 * last[:, :, 2])][:, 1].mean()

    plain = film("plain.gif", "--every", "0.8", "--size", "128x96")[1]
    colored = film("colored.gif", "--every", "0.8", "--size", "128x96", "--pressure")[1]
    first = played(colored)[0][0].astype(int)
    assert first[first[:, :, 0] > 1.2 * first[:, :, 2]][:, 1].mean() > green_of_the_finger(colored)
    assert green_of_the_finger(plain) != pytest.approx(green_of_the_finger(colored), abs=2.0)


def test_an_mp4_has_the_size_the_pace_and_the_length_that_were_asked_for(film):
    from imageio_ffmpeg import count_frames_and_secs, read_frames

    status, path = film("film.mp4", "--fps", "20")
    assert status == 0
    count, seconds = count_frames_and_secs(str(path))
    assert (count, seconds) == (17, pytest.approx(0.85, abs=0.01))
    about = next(read_frames(str(path)))
    assert (about["size"], about["fps"], about["codec"]) == ((64, 48), 20.0, "h264")


def test_a_folder_gets_a_picture_for_each_time_asked_for_and_keeps_none_of_an_earlier_film(film):
    status, path = film("frames", "--every", "0.2")
    assert status == 0
    assert sorted(p.name for p in path.iterdir()) == [f"frame_{k:04d}.png" for k in range(5)]
    (path / "mine.txt").write_text("kept")
    assert film("frames", "--every", "0.4", "--force") == (0, path)
    assert sorted(p.name for p in path.iterdir()) == [
        "frame_0000.png", "frame_0001.png", "frame_0002.png", "mine.txt",
    ]  # fmt: skip


def test_wrist_and_object_are_in_the_picture_from_first_to_last(settings):
    recording = film_trial(settings, placed(0, settings), 0.4)
    options = command.parser().parse_args(["-o", "x", "--size", "64x48", "--camera", "90", "0"])
    camera = command.camera_of(options, recording)
    reach = camera.distance * np.tan(np.radians(0.5 * Camera.view_angle))
    assert np.all(np.abs(recording.path[:, 2] - camera.target[2]) < reach)


def test_the_camera_stays_with_the_hand_when_the_object_flies_off(settings):
    recording = film_trial(settings, placed(0, settings), 0.1)
    options = command.parser().parse_args(["-o", "x", "--size", "64x48"])
    before = command.camera_of(options, recording)
    flung = [
        replace(state, object_position=state.object_position + [0.0, 0.0, 9.0 * (k > 3)])
        for k, state in enumerate(recording.states)
    ]
    after = command.camera_of(options, replace(recording, states=flung))
    assert after.distance <= before.distance < 2.0
    np.testing.assert_allclose(after.target, before.target, atol=0.1)


def test_a_wall_is_drawn_at_the_inclination_of_the_trial(settings):
    leaning = replace(settings, scene="wall", wall_inclination=60.0)
    recording = film_trial(leaning, placed(0, leaning), 0.8)
    assert recording.renderer.scene.wall.inclination == 60.0
    options = command.parser().parse_args(["-o", "x"])
    assert (
        command.camera_of(options, recording).yaw == -command.CAMERA_VIEWS["oblique"][0]
    )  # before it


def test_a_bag_is_shown_from_before_its_first_phase_to_the_end_of_its_last(grasp_bag):
    recording = film_bag(grasp_bag, 0.25, "single_finger", "cylinder", "table")
    assert len(recording.states) == 15  # from 0.5 to 4.0 s
    assert recording.renderer.layout.segments == 2
    assert recording.pressures[[2, -1], 0] == pytest.approx([0.0, 20e3])
    for time, state in zip(np.arange(0.5, 4.01, 0.25), recording.states, strict=True):
        turned = 2.0 * np.arccos(np.clip(state.joints[:, 3], -1, 1))
        np.testing.assert_allclose(turned, 0.1 * time, atol=0.003)
        assert state.object_position[2] == pytest.approx(0.03 + 0.1 * max(time - 3, 0), abs=0.003)


def test_a_bag_of_another_hand_is_refused(grasp_bag, film, capsys):
    assert film("film.gif", "--bag", str(grasp_bag), "--hand", "rbo_hand_2")[0] == 2
    assert "expected a recording of rbo_hand_2" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("name", "options", "says"),
    [
        ("film.avi", [], "expected a folder, .gif or .mp4, got .avi"),
        ("film.gif", ["--fps", "60"], "fps: expected at most 50"),
        ("film.mp4", ["--size", "65x48"], "size: expected even numbers"),
        ("film.gif", ["--object", "teapot"], "teapot"),
        ("film.gif", ["--every", "0.001"], "expected at least the step"),
        ("film.gif", ["--bag", "nowhere"], "nowhere: expected a bag"),
    ],
)
def test_what_cannot_be_filmed_is_refused_with_the_reason_and_leaves_no_file(
    film, capsys, name, options, says
):
    status, path = film(name, *options)
    assert (status, path.exists()) == (2, False)
    assert says in capsys.readouterr().err


def test_an_earlier_film_stays_unless_forced(film, capsys):
    _, path = film("film.gif", "--every", "0.8")
    before = path.read_bytes()
    assert film("film.gif", "--every", "0.4")[0] == 2
    assert "--force" in capsys.readouterr().err
    assert path.read_bytes() == before


def test_a_folder_in_place_of_a_film_is_refused_even_when_forced(film, tmp_path, capsys):
    (tmp_path / "film.gif").mkdir()
    (tmp_path / "frames").write_text("")
    assert film("film.gif", "--force")[0] == film("frames", "--force")[0] == 2
    told = capsys.readouterr().err
    assert "expected a file" in told and "expected a folder" in told


@pytest.mark.parametrize(
    "place", ["/proc/nowhere/film.gif", "/proc/frames", "/proc/film.mp4", "taken/film.gif"]
)
def test_a_place_that_cannot_be_written_is_named_before_anything_is_simulated(
    film, tmp_path, capsys, monkeypatch, place
):
    (tmp_path / "taken").write_text("a file")
    monkeypatch.setattr(command, "film_trial", None)
    status, path = film(place)
    assert status == 2
    said = capsys.readouterr().err
    assert f"softhand film: -o {path}: expected a place that can be written, got: " in said


def test_a_film_that_is_refused_leaves_no_folder(film, tmp_path):
    assert film("new/folder/film.gif", "--object", "teapot")[0] == 2
    assert not (tmp_path / "new").exists()
    (tmp_path / "film.gif").write_text("an earlier film")
    assert film("film.gif", "--object", "teapot", "--force")[0] == 2
    assert (tmp_path / "film.gif").read_text() == "an earlier film"


def test_the_last_line_counts_files_or_seconds(film, capsys):
    path = film("frames", "--every", "0.4")[1]
    assert capsys.readouterr().out == f"{path}: 3 PNG files, one each 0.4 s of simulation\n"
    path = film("film.gif", "--every", "0.4")[1]
    assert capsys.readouterr().out == f"{path}: 0.12 s at 25 pictures a second\n"


@pytest.mark.parametrize(("name", "library"), [("a.mp4", "imageio_ffmpeg"), ("a.gif", "PIL")])
def test_a_library_that_is_missing_is_named_before_anything_is_simulated(
    film, capsys, monkeypatch, name, library
):
    monkeypatch.setitem(__import__("sys").modules, library, None)
    monkeypatch.setattr(command, "film_trial", None)
    assert film(name)[0] == 2
    assert "pip install" in capsys.readouterr().err


def test_pictures_of_a_gif_keep_the_pace_in_hundredths_of_a_second():
    for fps in (7.0, 12.5, 24.0, 30.0, 50.0):
        durations = writing.gif_durations(100, fps)
        assert sum(durations) == pytest.approx(1e5 / fps, abs=5.01)
        assert set(np.mod(durations, 10)) == {0}


def test_a_cell_of_a_sweep_is_played_with_its_settings_and_placement(tmp_path):
    settings = TrialSettings("rbo_hand_1_push", "marker", step=0.005, without=("advance",))
    lines = [
        TrialTask(f"push_map/marker/10,-30/{k}", "marker", (0.01, -0.03), k, settings, placement)
        for k, placement in enumerate((Placement((0.2, 0.3)), Placement((0.1, 0.3), 1.1, 0.2, 0.9)))
    ]
    records = [json.dumps(line.describe()) + "\n" for line in lines]
    (tmp_path / "main").mkdir()
    (tmp_path / "main/results.jsonl").write_text("".join(records))

    def asked(cell):
        words = ["-o", "x", "--results", str(tmp_path), "--cell", cell]
        return command.trial_asked_for(command.parser().parse_args(words))

    assert asked("push_map/marker/10,-30") == (settings, lines[0].placement)
    assert asked("push_map/marker/10,-30/1") == (settings, lines[1].placement)
    with pytest.raises(ValueError, match="such as push_map/marker/10,-30/0.*got push_map/marker/1"):
        asked("push_map/marker/1,1")
