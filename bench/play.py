"""The page to play with, in the machine's chromium that draws by software: `python -m bench.play`.

Start to a hand that moves, pictures a second at 800 x 600 while a grasp is simulated beside it, and
memory over ten minutes in which a grasp begins each minute (`--minutes 4` is quicker).
"""

from __future__ import annotations

import argparse
import shutil
import subprocess
import sys
import time
from collections.abc import Callable
from contextlib import contextmanager
from typing import Any

import psutil
from playwright.sync_api import Page, sync_playwright

from bench.__main__ import table
from bench.row import at_least, at_most, stated

WINDOW = {"width": 800, "height": 600}
SOFTWARE = (
    "--no-sandbox",
    "--use-gl=angle",
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
)
FRAMES = "() => window.__viserTestpoints.rendererInfo.render.frame"
TRIANGLES = "() => window.__viserTestpoints.rendererInfo.render.triangles"
SLIDER = """() => { const found = document.querySelectorAll("[role=slider]");
  found[0]?.focus(); return found.length; }"""
PLACE = """name => {
  const found = [...document.querySelectorAll("button, [role=tab]")]
    .find(e => e.textContent.trim() == name && e.checkVisibility());
  const box = found?.getBoundingClientRect();
  return box ? [box.left + box.width / 2, box.top + box.height / 2] : null;
}"""
PICTURE = '() => document.querySelector("canvas[data-engine]").toDataURL()'
MEASURED = 20.0  # wall time over which pictures are counted [s]
SETTLED = 3  # grasps before memory is looked at first: the allocator has what it needs by then
ROUND = 60.0  # from grasp to grasp while memory is looked at [s]
PATIENCE = 120.0  # [s]


def run(minutes: float) -> list[dict[str, Any]]:
    """Rows of all that is measured."""
    with _page() as (server, browser, began):
        _wait(lambda: browser.evaluate(SLIDER), "sliders")
        still = browser.evaluate(PICTURE)
        browser.keyboard.press("End")
        _wait(lambda: browser.evaluate(PICTURE) != still, "a hand that moves")
        started = time.monotonic() - began
        pace = _pictures(browser)
        triangles = browser.evaluate(TRIANGLES)
        used = [_grasp(browser, server) for _ in range(1 + max(1, round(minutes)))]
        first, last = used[min(SETTLED, len(used) - 2)], used[-1]
    return [
        at_most("page: start to a hand that moves", started, "s", 15.0),
        at_least("page: pictures a second, RBO Hand 2 that grasps, software", pace, "1/s", 5.0),
        stated("page: triangles", triangles, ""),
        at_most(f"page: memory after {minutes:g} min", 100.0 * (last / first - 1.0), "%", 5.0),
        stated("page: memory after the first grasp", used[0] / 1e6, "MB"),
        stated("page: memory at the end", last / 1e6, "MB"),
    ]


def _grasp(browser: Page, server: psutil.Process) -> int:
    """Let the hand grasp; memory of the server after it [bytes]."""
    _press(browser, "Strategies", "run the strategy", "Hand")
    time.sleep(ROUND)
    return int(server.memory_info().rss)


def _press(browser: Page, *names: str) -> None:
    """Press by place: Playwright's own click waits for pictures that a slow machine owes."""
    for name in names:
        _wait(lambda name=name: browser.evaluate(PLACE, name), name)
        browser.mouse.click(*browser.evaluate(PLACE, name))


def _pictures(browser: Page) -> float:
    """Pictures a second while a strategy runs."""
    _press(browser, "Strategies", "run the strategy", "Hand")
    before, began = browser.evaluate(FRAMES), time.monotonic()
    time.sleep(MEASURED)
    return float(browser.evaluate(FRAMES) - before) / (time.monotonic() - began)


def _wait(condition: Callable[[], Any], what: str) -> None:
    end = time.monotonic() + PATIENCE
    while not condition():
        if time.monotonic() > end:
            raise RuntimeError(f"page: expected {what} within {PATIENCE:g} s")
        time.sleep(0.05)


@contextmanager
def _page() -> Any:
    """Process of the server, the page in a browser, and when the first was started [s]."""
    chromium = shutil.which("chromium") or shutil.which("google-chrome")
    if chromium is None:
        raise RuntimeError("page: expected chromium, got none: apt-get install chromium")
    began = time.monotonic()
    command = [sys.executable, "-m", "softhand_play.command", "--port", "8791"]
    server = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
    try:
        with sync_playwright() as driver:
            window = driver.chromium.launch(executable_path=chromium, args=SOFTWARE)
            page = window.new_page(viewport=WINDOW)
            page.set_default_timeout(1e3 * PATIENCE)
            for line in server.stdout:
                if line.startswith("softhand-play: http"):
                    page.goto(line.split()[1])
                    break
            yield psutil.Process(server.pid), page, began
            window.close()
    finally:
        server.terminate()
        server.wait()


def main(arguments: list[str] | None = None) -> int:
    """Print the table."""
    parser = argparse.ArgumentParser(prog="python -m bench.play", description=__doc__)
    parser.add_argument("--minutes", type=float, default=10.0, help="of memory (%(default)s)")
    print(table(run(parser.parse_args(arguments).minutes)))
    return 0


if __name__ == "__main__":
    sys.exit(main())
