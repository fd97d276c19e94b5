"""The page without a browser: what its buttons do."""

import json
from dataclasses import replace

import numpy as np
import pytest
from play_page import served, wait_until
from rosbags.convert.converter import convert

from grasp_strategies.sweep.trial_line import TrialLine
from grasp_strategies.trials import Placement, TrialSettings
from pneuflex_sim.hand.kinematics import HandShape
from softhand_play.player import FASTEST
from softhand_play.recorded import write_bag

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
    return wait_until(lambda: page.track, "the end of the strategy")


@pytest.fixture(scope="module")
def short(track):
    """Some instants of that run."""
    return replace(track, shots=track.shots[::10])


def test_a_strategy_runs_to_gripped(page, track):
    assert track.gripped
    assert page.told.startswith("gripped")
    assert list(track.phases)[:3] == ["approach", "touch", "oppose"]


def test_the_recorded_run_is_scrubbed(page, track):
    number = track.phases["lift"]
    page.strategies.jump("lift")
    wait_until(lambda: page.seen is track.shots[number], "the instant at which the lift begins")


def test_a_saved_bag_plays_as_it_was(page, short, tmp_path):
    write_bag(short, tmp_path / "bag")
    page.results.open_bag(tmp_path / "bag")
    began = short.shots[0].time
    for ours in short.shots[:-1]:
        theirs = page.track.shots[round((ours.time - began) / page.track.interval) + 1]
        assert np.allclose(np.abs(ours.state.joints), np.abs(theirs.state.joints), atol=1e-6)
        assert np.allclose(ours.state.object_position, theirs.state.object_position)
        assert np.allclose(ours.pressures, theirs.pressures)
    assert list(page.track.phases)[:3] == list(short.phases)[:3]


def test_a_bag_of_sqlite3_plays_too(page, short, tmp_path):
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
    assert list(page.track.phases)[:3] == list(short.phases)[:3]


@pytest.mark.parametrize("name", BAD)
def test_a_bad_file_becomes_a_sentence(page, name):
    page.tell("")
    page.attempt(lambda: page.dropped.open(name, BAD[name]))
    wait_until(lambda: page.told.startswith(name), "a sentence that names the file")
    assert "expected" in page.told
    assert "/tmp" not in page.told


def test_a_dropped_map_cannot_have_code_run(page, tmp_path):
    line = TrialLine("map/cylinder/0,0/1", "cylinder", (0.0, 0.0), 1, TrialSettings(), Placement())
    record = line.describe() | {"outcome": "none", "settings": {"allow_effect_files": True}}
    page.dropped.open("results.jsonl", json.dumps(record).encode() + b"\n")
    page.results.run_cell("0,0")
    wait_until(lambda: page.player.world.placement == Placement(), "the trial")
    assert not page.player.world.settings.allow_effect_files
    page.player.abort()


def bent(page, effect, pressure):
    """Height of a single finger's tip above the wrist [m] at a pressure [Pa] with an effect."""
    page.scene.scene.value, page.scene.hand.value = "stand", "single_finger"
    page.scene.effect.value = effect
    before = page.player.generation
    page.player.play(page.scene.wanted())
    wait_until(lambda: page.player.generation > before, f"a finger with {effect}")
    page.player.command_pressures(np.array([pressure]))
    wait_until(lambda: abs(page.player.shots[-1].pressures[0] - pressure) < 2.5e3, "the pressure")
    reached = page.player.shots[-1].time
    wait_until(lambda: page.player.shots[-1].time > reached + 2.0, "a finger at rest")
    shot = page.player.shots[-1]
    tips = HandShape(page.player.stage.layout).fingertips(shot.state.joints)
    return tips["finger"][0][2]


def test_an_effect_that_is_switched_on_bends_the_finger_less(page):
    assert bent(page, "yeoh_stiffening", 30e3) > bent(page, "none", 30e3) + 0.005
