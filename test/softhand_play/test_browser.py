"""The page in a real browser."""

import json
from dataclasses import asdict

import numpy as np
import pytest
from play_page import served, wait_until

from grasp_strategies.sweep.trial_line import TrialLine
from softhand_play.player import FASTEST

pytestmark = pytest.mark.timeout(600)

DISTANCE, HEIGHT = 0.5, 0.44  # of the camera from the hand, and above the ground [m]
INDEX = 0.036  # where the index finger stands along y [m]


@pytest.fixture(scope="module")
def page():
    with served(hand="rbo_hand_2", scene="stand") as page:
        page.server.initial_camera.position = (DISTANCE, 0.0, HEIGHT)
        page.server.initial_camera.look_at = (0.0, 0.0, HEIGHT)
        yield page


def tip_height(picture, angle):
    """Height [mm] of the uppermost point of the index finger in a picture from the palm's side,
    from the picture's middle; `angle` [rad] is the vertical view angle.
    """
    high, wide = picture.shape[:2]
    metres_a_pixel = 2.0 * DISTANCE * np.tan(0.5 * angle) / high
    column = round(0.5 * wide + INDEX / metres_a_pixel)
    strip = picture[:, column - 3 : column + 4].min(axis=(1, 2))
    return 1e3 * metres_a_pixel * (0.5 * high - np.flatnonzero(strip < 250)[0])


def test_a_slider_bends_the_finger_on_the_canvas(page, open_window):
    window = open_window(page)
    (client,) = wait_until(page.server.get_clients, "a browser").values()
    wait_until(lambda: window.picture().min() < 200, "a hand on the canvas")
    before = tip_height(window.picture(), client.camera.fov)
    window.slide("channel b")
    wait_until(lambda: page.player.shots[-1].pressures[1] > 60e3, "the pressure")
    wait_until(
        lambda: before - tip_height(window.picture(), client.camera.fov) > 20.0,
        "the tip of the index finger 20 mm lower",
    )


def test_two_browsers_see_the_same_and_a_lost_connection_comes_back(page, open_window):
    windows = open_window(page), open_window(page)
    windows[0].slide("channel c")
    wait_until(lambda: windows[1].value("channel c") == "105", "the slider in the other browser")
    before = set(page.server.get_clients())
    page.server._websock_server.disconnect_all_clients()
    wait_until(lambda: len(set(page.server.get_clients()) - before) == 2, "both browsers back")
    windows[1].slide("channel c", "Home")
    wait_until(lambda: windows[0].value("channel c") == "0", "the slider moved in the other, again")
    wait_until(lambda: page.player.shots[-1].pressures[2] < 5e3, "the air let out")


def test_a_strategy_grips_its_bag_plays_and_its_cell_gives_the_same_verdict(
    open_window, tmp_path, monkeypatch
):
    monkeypatch.chdir(tmp_path)
    with served() as page:
        page.player.pace.speed = FASTEST
        window = open_window(page)
        window.press("Strategies")
        window.press("run the strategy")
        window.reads("gripped")
        window.press("save a bag")
        window.reads("saved: out/play/")
        result, world = page.player.result, page.player.world
        (tmp_path / "results.jsonl").write_text(a_cell(world, result))
        window.press("Results")
        window.fill("folder", str(next((tmp_path / "out/play").iterdir())))
        window.press("open the bag")
        window.reads("instants; Strategies plays them")
        assert any(page.seen is shot for shot in page.track.shots)
        window.fill("results", str(tmp_path))
        window.press("open the map")
        wait_until(lambda: window.value("cell [mm]") == "0,0", "the map's cell")
        window.press("run this trial again")
        window.reads("gripped in the map")
        wait_until(lambda: page.player.result not in (None, result), "the verdict")
        assert page.player.result.outcome == result.outcome
        assert page.player.result.duration == result.duration
        assert page.player.result.lift_height == result.lift_height


def a_cell(world, result):
    """A line of results of a world and what came out."""
    name = world.settings.object
    line = TrialLine(f"map/{name}/0,0/1", name, (0.0, 0.0), 1, world.settings, world.placement)
    return json.dumps(line.describe() | asdict(result)) + "\n"
