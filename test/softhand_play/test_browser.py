"""The page in a real browser."""

import json
from dataclasses import asdict

import numpy as np
import pytest
from play_page import hurry, served, wait_until

from softhand_common.documents.output_file import plain
from softhand_trials.sweep.trial_task import TrialTask

pytestmark = pytest.mark.timeout(600)

DISTANCE, HEIGHT = 0.5, 0.44  # of the camera from the hand, and above the ground [m]
INDEX = 0.036  # where the index finger stands along y [m]


@pytest.fixture(scope="module")
def page():
    with served(hand="rbo_hand_2", scene="stand") as page:
        wait_until(lambda: page.seen, "the page's own view of the hand")
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


def test_a_slider_bends_the_finger_on_the_canvas_and_a_bad_file_becomes_a_sentence(
    page, open_window
):
    window = open_window(page)
    (client,) = wait_until(page.server.get_clients, "a browser").values()
    wait_until(lambda: window.picture().min() < 200, "a hand on the canvas")
    before = tip_height(window.picture(), client.camera.fov)
    window.slide("b: index")
    wait_until(lambda: page.player.frames[-1].pressures[1] > 60e3, "the pressure")
    wait_until(
        lambda: before - tip_height(window.picture(), client.camera.fov) > 20.0,
        "the tip of the index finger 20 mm lower",
    )
    window.drop("bad.yaml", "format: 3")
    window.reads("bad.yaml: format: expected")


def test_two_browsers_see_the_same_and_a_lost_connection_comes_back(page, open_window):
    page.player.paused = True  # two pictures of what moves are much to draw
    windows = open_window(page), open_window(page)
    windows[0].slide("c: palm inner, thumb")
    wait_until(
        lambda: windows[1].value("c: palm inner, thumb") == "105", "the slider in the other browser"
    )
    before = set(page.server.get_clients())
    page.server._websock_server.disconnect_all_clients()
    wait_until(lambda: len(set(page.server.get_clients()) - before) == 2, "both browsers back")
    windows[1].slide("c: palm inner, thumb", "Home")
    wait_until(
        lambda: windows[0].value("c: palm inner, thumb") == "0",
        "the slider moved in the other, again",
    )
    page.player.paused = False
    wait_until(lambda: page.player.frames[-1].pressures[2] < 5e3, "the air let out")


def test_a_strategy_grips_its_bag_plays_and_its_cell_gives_the_same_verdict(
    open_window, tmp_path, monkeypatch
):
    monkeypatch.chdir(tmp_path)
    with served(folders=[tmp_path]) as page:
        hurry(page.player)
        window = open_window(page)
        window.press("Strategies")
        window.press("run the strategy")
        window.reads("gripped: ")
        result, world = page.player.result, page.player.world
        window.press("save a bag")
        window.reads("saved: out/play/")
        (bag,) = (tmp_path / "out/play").iterdir()
        window.press("Results")
        window.choose("folder", str(bag.relative_to(tmp_path)))
        window.press("open the bag")
        window.reads("s, played back in Strategies")
        wait_until(lambda: page.seen in page.player.track.frames[5:], "the bag, played")
        (tmp_path / "out/results.jsonl").write_text("".join(cells(world, result)))
        window.press("look for new files")
        window.choose("results", "out/results.jsonl")
        window.press("open the map")
        window.reads("click on a square")
        window.click_on(page, page.results.places["10,0"])
        window.reads("the map has: gripped")
        assert page.player.result is not result
        assert page.player.result == result


def cells(world, result):
    """Lines of results of a world and what came out, as two cells of which the first is another."""
    name = world.settings.object
    for cell, outcome in (("0,0", "none"), ("10,0", result.outcome)):
        at = (1e-3 * float(cell.split(",")[0]), 0.0)
        line = TrialTask(f"map/{name}/{cell}/1", name, at, 1, world.settings, world.placement)
        yield json.dumps(plain(line.describe() | asdict(result) | {"outcome": outcome})) + "\n"
