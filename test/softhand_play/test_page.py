"""The page without a browser: what its buttons do."""

import json
import threading
from dataclasses import replace
from functools import partial

import numpy as np
import pytest
import viser
from imageio_ffmpeg import count_frames_and_secs
from play_page import hurry, served, wait_until
from rosbags.convert.converter import convert

from pneuflex_sim.hand.kinematics import HandShape
from pneuflex_sim.pictures import hand_picture
from softhand_play.frames import INTERVAL, World
from softhand_play.hand_tab import AIR_MASS_LABEL, PRESSURE_LABEL
from softhand_play.recorded import write_bag
from softhand_trials.sweep.trial_task import TrialTask
from softhand_trials.trials import Placement, TrialSettings

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
        hurry(page.player)
        yield page


@pytest.fixture(scope="module")
def track(page):
    """The usual strategy, run to its end."""
    page.strategies.run()
    return wait_until(lambda: page.player.track, "the end of the strategy")


@pytest.fixture(scope="module")
def short(track):
    """Some instants of that run."""
    return replace(track, frames=track.frames[::10])


@pytest.fixture
def still(page, monkeypatch):
    """What goes on stands still, so that all of the machine is there for the test."""
    monkeypatch.setattr(page.player, "paused", True)


def test_a_strategy_runs_to_gripped_and_then_what_goes_on_is_shown(page, track):
    wait_until(lambda: page.message.startswith("gripped"), "the verdict")
    assert list(track.phases)[:3] == ["approach", "touch", "oppose"]
    wait_until(lambda: page.seen.time > track.frames[-1].time, "what goes on")


def test_sliders_and_handle_follow_a_strategy_to_its_end(page, track):
    wrist = track.frames[-1].state.wrist_position
    wait_until(lambda: np.allclose(page.hand.handle.position, wrist, atol=1e-3), "the handle")
    reached = [1e3 * slider.value for slider in page.hand.sliders]
    steps = [1e3 * slider.step for slider in page.hand.sliders]
    assert (np.abs(reached - track.frames[-1].pressures) < steps).all()
    assert np.max(reached) > 50e3


def test_the_recorded_run_is_scrubbed(page, track):
    number = track.phases["lift"]
    page.strategies.jump("lift")
    wait_until(lambda: page.seen is track.frames[number], "the instant at which the lift begins")


def test_a_film_is_saved(page, short, still, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    page.player.track, track = replace(short, frames=short.frames[:3]), page.player.track
    page.strategies.save(".mp4")
    page.player.track = track
    assert page.message.startswith("saved: out/play/")
    (path,) = (tmp_path / "out/play").iterdir()
    frames, _ = count_frames_and_secs(path)
    assert frames == 3


def test_a_saved_bag_plays_as_it_was(page, short, still, tmp_path):
    write_bag(short, tmp_path / "bag")
    page.results.open_bag(tmp_path / "bag")
    began = short.frames[0].time
    for ours in short.frames[:-1]:
        theirs = page.player.track.frames[round((ours.time - began) / INTERVAL) + 1]
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
    page.report("")
    page.attempt(lambda: page.dropped.open(name, BAD[name]))
    wait_until(lambda: page.message.startswith(name), "a sentence that names the file")
    assert "expected" in page.message
    assert "/tmp" not in page.message


def test_a_dropped_map_cannot_have_code_run_and_its_verdict_stays_to_be_read(page):
    line = TrialTask("map/cylinder/0,0/1", "cylinder", (0.0, 0.0), 1, TrialSettings(), Placement())
    record = line.describe() | {"outcome": "none", "settings": {"allow_effect_files": True}}
    page.dropped.open("results.jsonl", json.dumps(record).encode() + b"\n")
    page.results.run_cell("0,0")
    wait_until(lambda: page.player.is_running, "the trial")
    assert not page.player.world.settings.allow_effect_files
    assert page.message == "map/cylinder/0,0/1: none in the map; it runs again"
    page.player.abort()
    wait_until(lambda: page.message.endswith("the map has: none"), "the end of the trial")


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
    wait_until(lambda: page.player.world is world and page.player.frames, f"a finger with {effect}")
    page.player.command_masses(np.array([AIR]))
    wait_until(lambda: abs(page.player.frames[-1].masses[0] - AIR) < 1e-8, "the air")
    filled = page.player.frames[-1].time
    wait_until(lambda: page.player.frames[-1].time > filled + 2.0, "a finger at rest")
    state = page.player.frames[-1].state
    return HandShape(page.player.now.static_scene.layout).fingertips(state.joints)["finger"][0][2]


def test_a_mesh_that_is_dropped_where_no_object_can_be_becomes_a_sentence(page):
    page.scene.scene.value = "stand"
    page.player.play(page.scene.wanted())
    wait_until(lambda: page.player.now.static_scene.object is None, "a stand")
    page.attempt(lambda: page.dropped.open("box.stl", b"xx"))
    assert page.message == "box.stl: expected a scene with an object, got stand"


def moved(slider):
    """What a slider that a user moves calls."""
    (act,) = slider._impl.update_cb
    act(viser.GuiEvent(client=object(), client_id=0, target=slider))


def test_a_slider_commands_what_it_was_made_for_while_the_quantity_changes(page, monkeypatch):
    commanded = []
    for quantity in ("pressures", "masses"):
        note = partial(lambda quantity, values: commanded.append((quantity, values)), quantity)
        monkeypatch.setattr(page.player, f"command_{quantity}", note)
    begun, ended = threading.Event(), threading.Event()

    def slow(*arguments, masses=hand_picture.air_masses_at):
        begun.set()
        ended.wait(60.0)
        return masses(*arguments)

    monkeypatch.setattr(hand_picture, "air_masses_at", slow)
    of_pressure = wait_until(lambda: page.hand.sliders, "sliders")[0]
    page.hand._quantity.value = AIR_MASS_LABEL
    assert begun.wait(60.0)
    of_pressure.value = 50.0 * of_pressure.step
    moved(of_pressure)
    ended.set()
    wait_until(lambda: page.hand.sliders[0] is not of_pressure, "other sliders")
    moved(of_pressure)  # what the browser has sent before comes late
    wait_until(lambda: page.hand._shown == AIR_MASS_LABEL, "the other quantity")
    moved(page.hand.sliders[0])
    page.hand._quantity.value = PRESSURE_LABEL
    wait_until(lambda: page.hand._shown == PRESSURE_LABEL, "the first quantity")
    assert [quantity for quantity, _ in commanded] == ["pressures", "pressures", "masses"]
    assert commanded[0][1][0] == commanded[1][1][0] == 1e3 * of_pressure.value > 1e3


def test_an_effect_that_is_switched_on_bends_the_finger_less(page):
    assert bent(page, "yeoh_stiffening") > bent(page, "none") + 0.002
