"""The page without a browser: what its buttons do."""

import json
from dataclasses import replace

import numpy as np
import pytest
from imageio_ffmpeg import count_frames_and_secs
from play_page import served, wait_until
from rosbags.convert.converter import convert

from grasp_strategies.sweep.trial_line import TrialLine
from grasp_strategies.trials import Placement, TrialSettings
from pneuflex_sim.hand.kinematics import HandShape
from softhand_play.player import FASTEST
from softhand_play.recorded import write_bag
from softhand_play.shots import INTERVAL, World

BAD = {
    "bad.stl": b"xx",
    "bad.yaml": b"format: 3",
    "code.py": b"raise SystemExit",
    "model.yaml": b"format: softhand-model/1\nbase: pneuflex\neffects: [{name: x, file: y.py}]",
    "bag.mcap": b"\x89MC",
    "results.jsonl": b"[]\n",
}


pytestmark = pytest.mark.timeout(300)


@pytest.fixture(scope="module")
def page():
    with served() as page:
        page.player.pace.speed = FASTEST
        yield page


@pytest.fixture(scope="module")
def track(page):
    """The usual strategy, run to its end."""
    page.strategies.run()
    return wait_until(lambda: page.player.track, "the end of the strategy")


@pytest.fixture(scope="module")
def short(track):
    """Some instants of that run."""
    return replace(track, shots=track.shots[::10])


@pytest.fixture
def still(page, monkeypatch):
    """What goes on stands still, so that all of the machine is there for the test."""
    monkeypatch.setattr(page.player, "paused", True)


def test_a_strategy_runs_to_gripped_and_then_what_goes_on_is_shown(page, track):
    wait_until(lambda: page.told.startswith("gripped"), "the verdict")
    assert list(track.phases)[:3] == ["approach", "touch", "oppose"]
    wait_until(lambda: page.seen.time > track.shots[-1].time, "what goes on")


def test_sliders_and_handle_follow_a_strategy_to_its_end(page, track):
    wrist = track.shots[-1].state.wrist_position
    wait_until(lambda: np.allclose(page.hand.handle.position, wrist, atol=1e-3), "the handle")
    reached = [1e3 * slider.value for slider in page.hand.sliders]
    steps = [1e3 * slider.step for slider in page.hand.sliders]
    assert (np.abs(reached - track.shots[-1].pressures) < steps).all()
    assert np.max(reached) > 50e3


def test_the_recorded_run_is_scrubbed(page, track):
    number = track.phases["lift"]
    page.strategies.jump("lift")
    wait_until(lambda: page.seen is track.shots[number], "the instant at which the lift begins")


def test_a_film_is_saved(page, short, still, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    page.player.track, track = replace(short, shots=short.shots[:3]), page.player.track
    page.strategies.save(".mp4")
    page.player.track = track
    assert page.told.startswith("saved: out/play/")
    (path,) = (tmp_path / "out/play").iterdir()
    frames, _ = count_frames_and_secs(path)
    assert frames == 3


def test_a_saved_bag_plays_as_it_was(page, short, still, tmp_path):
    write_bag(short, tmp_path / "bag")
    page.results.open_bag(tmp_path / "bag")
    began = short.shots[0].time
    for ours in short.shots[:-1]:
        theirs = page.player.track.shots[round((ours.time - began) / INTERVAL) + 1]
        assert np.allclose(np.abs(ours.state.joints), np.abs(theirs.state.joints), atol=1e-6)
        assert np.allclose(ours.state.object_position, theirs.state.object_position)
        assert np.allclose(ours.pressures, theirs.pressures)
    assert list(page.player.track.phases)[:3] == list(short.phases)[:3]


def test_a_bag_of_sqlite3_plays_too(page, short, still, tmp_path):
    write_bag(short, tmp_path / "mcap")
    whole = dict.fromkeys(("exclude_topics", "include_topics"), ())
    whole |= dict.fromkeys(("exclude_msgtypes", "include_msgtypes"), ())
    convert(
        [tmp_path / "mcap"],
        tmp_path / "sqlite3",
        dst_storage="sqlite3",
        dst_version=9,
        compress=None,
        compress_mode="file",
        default_typestore=None,
        typestore=None,
        **whole,
    )
    assert list((tmp_path / "sqlite3").glob("*.db3"))
    page.results.open_bag(tmp_path / "sqlite3")
    assert list(page.player.track.phases)[:3] == list(short.phases)[:3]


@pytest.mark.parametrize("name", BAD)
def test_a_bad_file_becomes_a_sentence(page, name):
    page.tell("")
    page.attempt(lambda: page.dropped.open(name, BAD[name]))
    wait_until(lambda: page.told.startswith(name), "a sentence that names the file")
    assert "expected" in page.told
    assert "/tmp" not in page.told


def test_a_dropped_map_cannot_have_code_run_and_its_verdict_stays_to_be_read(page):
    line = TrialLine("map/cylinder/0,0/1", "cylinder", (0.0, 0.0), 1, TrialSettings(), Placement())
    record = line.describe() | {"outcome": "none", "settings": {"allow_effect_files": True}}
    page.dropped.open("results.jsonl", json.dumps(record).encode() + b"\n")
    page.results.run_cell("0,0")
    wait_until(lambda: page.player.is_running, "the trial")
    assert not page.player.world.settings.allow_effect_files
    assert page.told == "map/cylinder/0,0/1: none in the map; it runs again"
    page.player.abort()
    wait_until(lambda: page.told.endswith("the map has: none"), "the end of the trial")


def test_of_two_wishes_the_later_is_met(page):
    for strategy in ("surface_constrained", "rbo_hand_1_push"):
        page.player.run_strategy(World(TrialSettings(strategy=strategy)))
    wait_until(lambda: page.player.is_running, "the second")
    assert page.player.world.settings.strategy == "rbo_hand_1_push"
    page.player.abort()
    wait_until(lambda: not page.player.is_running, "the end")


AIR = 1.25e-5  # of a single finger [kg]: five of the smallest pulses


def bent(page, effect):
    """Height of a single finger's tip above the wrist [m] with some air and an effect."""
    with page.drawing:  # or what was played before may be chosen in its place
        page.scene.scene.value, page.scene.hand.value = "stand", "single_finger"
        page.scene.effect.value = effect
        world = page.scene.wanted()
    page.player.play(world)
    wait_until(lambda: page.player.world is world and page.player.shots, f"a finger with {effect}")
    page.player.command_masses(np.array([AIR]))
    wait_until(lambda: abs(page.player.shots[-1].masses[0] - AIR) < 1e-8, "the air")
    filled = page.player.shots[-1].time
    wait_until(lambda: page.player.shots[-1].time > filled + 2.0, "a finger at rest")
    state = page.player.shots[-1].state
    return HandShape(page.player.now.stage.layout).fingertips(state.joints)["finger"][0][2]


def test_a_mesh_that_is_dropped_where_no_object_can_be_becomes_a_sentence(page):
    page.scene.scene.value = "stand"
    page.player.play(page.scene.wanted())
    wait_until(lambda: page.player.now.stage.object is None, "a stand")
    page.attempt(lambda: page.dropped.open("box.stl", b"xx"))
    assert page.told == "box.stl: expected a scene with an object, got stand"


def test_an_effect_that_is_switched_on_bends_the_finger_less(page):
    assert bent(page, "yeoh_stiffening") > bent(page, "none") + 0.002
