"""The page in a real browser."""

import numpy as np
import pytest
from play_page import served, wait_until

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


def test_a_strategy_that_is_run_from_the_page_grips(open_window, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with served() as page:
        page.player.pace.speed = FASTEST
        window = open_window(page)
        window.press("Strategies")
        window.press("run the strategy")
        window.reads("gripped")
        assert page.player.result.gripped
