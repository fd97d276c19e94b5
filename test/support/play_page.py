"""A page in this process, and a real browser that looks at it."""

import base64
import io
import threading
import time
from contextlib import contextmanager
from functools import partial

import numpy as np
import pytest
from PIL import Image
from scipy.spatial.transform import Rotation

WINDOW = {"width": 640, "height": 360}
SOFTWARE = (
    "--no-sandbox",
    "--use-gl=angle",
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
    "--disable-gpu-compositing",  # or what turns while the lab computes would take half a core
)
# by software a picture takes a core for tens of milliseconds: five a second, not sixty
SELDOM = """
requestAnimationFrame = draw => setTimeout(() => draw(performance.now()), 200);
cancelAnimationFrame = clearTimeout;
"""
FRAMES = "() => window.__viserTestpoints.rendererInfo.render.frame"
PICTURE = '() => document.querySelector("canvas[data-engine]").toDataURL()'
FIND = """([name, what]) => {
  let row = [...document.querySelectorAll("body *")]
    .find(e => !e.children.length && e.textContent.trim() == name && e.checkVisibility());
  while (row && !row.querySelector(what)) row = row.parentElement;
  const found = row?.querySelector(what);
  found?.focus();
  found?.select?.();
  return found ? [found.value ?? ""] : null;
}"""
PLACE = """name => {
  const found = [...document.querySelectorAll("button, [role=tab]")]
    .find(e => e.textContent.trim() == name && e.checkVisibility());
  found?.scrollIntoView({block: "center"});
  const box = found?.getBoundingClientRect();
  return box ? [box.left + box.width / 2, box.top + box.height / 2] : null;
}"""
DROP = """([name, text]) => {
  const dataTransfer = new DataTransfer();
  dataTransfer.items.add(new File([text], name));
  dispatchEvent(new DragEvent("drop", {dataTransfer, cancelable: true}));
}"""
CANVAS = """() => {
  const box = document.querySelector("canvas[data-engine]").getBoundingClientRect();
  return [box.left, box.top, box.width, box.height];
}"""
PATIENCE = 150.0  # [s]; all wait for what shall happen, no longer


def wait_until(condition, what, patience=PATIENCE):
    """Wait for something to hold; returns what it gave."""
    end = time.monotonic() + patience
    while time.monotonic() < end:
        found = condition()
        if found:
            return found
        time.sleep(0.1)
    raise AssertionError(f"expected {what} within {patience:g} s")


class Window:
    """A page in the browser."""

    def __init__(self, tab, address):
        self.tab = tab
        tab.set_default_timeout(1e3 * PATIENCE)
        tab.goto(f"{address}?fixedDpr=0.5")  # a quarter of the pixels: it draws by software
        self.reads("Hand")

    def picture(self):
        """What the canvas shows (height, width, 3)."""
        data = base64.b64decode(self.tab.evaluate(PICTURE).partition(",")[2])
        image = Image.open(io.BytesIO(data)).convert("RGBA")
        white = Image.new("RGBA", image.size, "white")
        return np.asarray(Image.alpha_composite(white, image))[:, :, :3]

    def find(self, name, what):
        """Focus what stands behind a label; its value."""
        arguments = [name, what]
        return wait_until(lambda: self.tab.evaluate(FIND, arguments), f"{what} of {name!r}")[0]

    def slide(self, name, key="End"):
        """Move a slider by a key."""
        self.find(name, "[role=slider]")
        self.tab.keyboard.press(key)

    def value(self, name):
        """Number or text of an input."""
        return self.find(name, "input")

    def fill(self, name, text, handle):
        """Put a text into an input, and wait until it has come to its handle: what is sent less
        than 50 ms before a press is lost (viser sends the latest alone).
        """
        self.find(name, "input")
        self.tab.keyboard.type(text)
        wait_until(lambda: handle.value == text, f"the text in {name!r}")

    def choose(self, name, option):
        """Choose an option of a dropdown."""
        self.find(name, "input")
        self.tab.keyboard.press("ArrowDown")
        self.tab.get_by_role("option", name=option, exact=True).click()

    def press(self, name):
        """Press a button, or choose a tab, with the mouse."""
        self.tab.mouse.click(*wait_until(lambda: self.tab.evaluate(PLACE, name), f"button {name}"))

    def click_on(self, page, point):
        """Click on a point (3,) [m] of the scene once it is drawn, as this one browser shows it."""
        drawn = self.tab.evaluate(FRAMES)
        wait_until(lambda: self.tab.evaluate(FRAMES) > drawn + 3, "pictures")
        (client,) = page.server.get_clients().values()
        camera = client.camera
        view = Rotation.from_quat(np.roll(camera.wxyz, -1)).inv().apply(point - camera.position)
        left, top, wide, high = self.tab.evaluate(CANVAS)
        pixels = 0.5 * high / np.tan(0.5 * camera.fov) / view[2]
        self.tab.mouse.click(
            left + 0.5 * wide + pixels * view[0], top + 0.5 * high + pixels * view[1]
        )

    def drop(self, name, text):
        """Drop a file of this name with a text onto the page."""
        self.tab.evaluate(DROP, [name, text])

    def text(self):
        """All that is to be read."""
        return self.tab.evaluate("() => document.body.innerText")

    def reads(self, words):
        """Wait until words are to be read."""
        wait_until(lambda: words in self.text(), f"the words {words!r}")


def hurry(player):
    """Run strategies as fast as possible. What goes on beside them keeps to real time: it is waited
    for by what it shows, and would take a core.
    """
    from softhand_play.player import FASTEST_PACE, Pace

    class Hurried(Pace):
        def wait(self, simulated):
            speed = FASTEST_PACE if player.is_running else 1.0
            if speed != self.speed:
                self.speed = speed
                self.anchor(simulated)
            super().wait(simulated)

    player.pace = Hurried()


@contextmanager
def served(folders=(), **settings):
    """A page of a world, served from this process; it may open the files of `folders`."""
    pytest.importorskip("viser")
    from softhand_play.frames import World
    from softhand_play.page import Page
    from softhand_play.player import Player
    from softhand_trials.trials import TrialSettings

    player = partial(Player, World(TrialSettings(**settings)))
    page = Page("127.0.0.1", 0, player, folders=folders)
    thread = threading.Thread(target=page.run)
    thread.start()
    try:
        wait_until(lambda: page.player.frames, "a hand")
        yield page
    finally:
        page.close()
        thread.join()
