"""Draws docs/figures/play.gif (`make figures NAME=play`): the page while the hand grasps.

The strategy runs first; then its frames are shown one by one, each until the browser has drawn it,
so that a slow machine makes the same film.
"""

from __future__ import annotations

import shutil
import sys
import threading
import time
from functools import partial
from io import BytesIO
from pathlib import Path

import numpy as np
from PIL import Image
from playwright.sync_api import Page as Tab
from playwright.sync_api import sync_playwright

from softhand_bringup.film.writing import open_film
from softhand_play.frames import World
from softhand_play.page import Page
from softhand_play.player import FASTEST_PACE, Player

OUT = Path(__file__).parents[1] / "docs" / "figures" / "play.gif"
WINDOW = {"width": 960, "height": 600}
SOFTWARE = (
    "--no-sandbox",
    "--use-gl=angle",
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
)
PICTURES, PACE = 16, 3.0  # of the film, and how many a second
CAMERA, LOOK_AT = (0.5, -0.45, 0.3), (0.0, 0.0, 0.14)  # [m]
FRAMES = "() => window.__viserTestpoints.rendererInfo.render.frame"
HIDDEN = ".mantine-Notifications-root { display: none }"  # what the client says of the browser
LIMIT = 180e3  # for a picture [ms]


def main() -> int:
    """Run a strategy and take its pictures; 0, or 1 without a browser."""
    chromium = shutil.which("chromium") or shutil.which("google-chrome")
    if chromium is None:
        print("draw_play: expected chromium, got none: apt-get install chromium", file=sys.stderr)
        return 1
    page = Page("127.0.0.1", 0, partial(Player, World()))
    page.server.initial_camera.position, page.server.initial_camera.look_at = CAMERA, LOOK_AT
    thread = threading.Thread(target=page.run)
    thread.start()
    try:
        with sync_playwright() as driver:
            window = driver.chromium.launch(executable_path=chromium, args=SOFTWARE)
            tab = window.new_page(viewport=WINDOW)
            tab.set_default_timeout(LIMIT)
            tab.goto(page.server.address)
            _film(page, tab)
            window.close()
    finally:
        page.close()
        thread.join()
    return 0


def _film(page: Page, tab: Tab) -> None:
    """Let the hand grasp, then show and photograph the run."""
    while not page.player.frames:
        time.sleep(0.1)
    page.player.pace.speed = FASTEST_PACE
    page.strategies.run()
    while page.player.track is None:
        time.sleep(0.1)
    page.player.paused = True
    while not tab.evaluate("() => !!window.__viserTestpoints"):
        time.sleep(0.5)
    tab.add_style_tag(content=HIDDEN)
    frames = page.player.track.frames
    with open_film(OUT, PACE, (WINDOW["width"], WINDOW["height"]), force=True) as film:
        for number in np.linspace(0, len(frames) - 1, PICTURES).round().astype(int):
            page.strategies.look_at(number)
            tab.get_by_text(f"{frames[number].time:.1f} s, recorded").wait_for()
            before = tab.evaluate(FRAMES)
            while tab.evaluate(FRAMES) < before + 2:
                time.sleep(0.2)
            film.add(np.asarray(Image.open(BytesIO(tab.screenshot())).convert("RGB")))
            print(f"draw_play: {frames[number].time:.1f} s of {frames[-1].time:.1f} s", flush=True)


if __name__ == "__main__":
    sys.exit(main())
