"""A real browser without a window: what a page looks like in it, and what it complains about."""

import json
import re
import shutil
import subprocess
from dataclasses import dataclass
from html import unescape
from pathlib import Path

import pytest

NAMES = ("chromium", "chromium-browser", "google-chrome", "chrome")
TIME_LIMIT = 60.0  # [s]
PROBE = """<pre id="probe"></pre><script>
const rect = e => e.getBoundingClientRect();
const box = e => [rect(e).left, rect(e).top, rect(e).right, rect(e).bottom];
const level = t => !/rotate\\(-?[1-9]/.test(t.getAttribute("transform") || "");
const figures = [...document.querySelectorAll("figure")].map(f => {
  const svg = f.querySelector("svg");
  return {name: f.id, label: svg.getAttribute("aria-label"), box: box(svg),
    caption: f.querySelector("figcaption").textContent,
    marks: [...svg.querySelectorAll("path, use")].filter(
      e => rect(e).width + rect(e).height > 0).length,
    texts: [...svg.querySelectorAll("text")].filter(level).map(t => [t.textContent, ...box(t)])};
});
document.getElementById("probe").textContent = JSON.stringify({figures,
  fetched: performance.getEntriesByType("resource").map(e => e.name),
  width: [document.documentElement.scrollWidth, document.documentElement.clientWidth]});
</script>"""


@dataclass(frozen=True)
class Rendered:
    """What a browser made of a page: figures with boxes [pixels], addresses it fetched, messages
    of its console, and width of content and window [pixels].
    """

    figures: list
    fetched: list
    console: list
    width: tuple


def find_browser():
    """Path of a Chromium; skips the test without one."""
    found = next(filter(None, map(shutil.which, NAMES)), None)
    if found is None:
        pytest.skip(f"no browser: none of {', '.join(NAMES)} is installed")
    return found


def render(page: Path, folder: Path, width=1200):
    """Load a page, with a script at its end that measures it."""
    probed = folder / f"probed-{page.name}"
    probed.write_text(page.read_text(encoding="utf-8").replace("</body>", PROBE + "</body>"))
    command = [
        find_browser(), "--headless", "--no-sandbox", "--disable-gpu", "--enable-logging=stderr",
        "--v=0", f"--user-data-dir={folder / 'profile'}", f"--window-size={width},2000",
        "--dump-dom", probed.as_uri(),
    ]  # fmt: skip
    done = subprocess.run(command, capture_output=True, text=True, timeout=TIME_LIMIT, check=True)
    measured = re.search(r'<pre id="probe">(.*?)</pre>', done.stdout, re.DOTALL)
    content = json.loads(unescape(measured.group(1))) if measured and measured.group(1) else {}
    console = [line for line in done.stderr.splitlines() if "CONSOLE" in line]
    return Rendered(
        content.get("figures", []), content.get("fetched", []), console,
        tuple(content.get("width", (0, 0))),
    )  # fmt: skip


def overlapping(figure):
    """Pairs of level texts of a figure of which one covers a part of the other."""
    texts = [entry for entry in figure["texts"] if entry[0].strip()]
    pairs = []
    for index, (first, *a) in enumerate(texts):
        for second, *b in texts[index + 1 :]:
            wide = min(a[2], b[2]) - max(a[0], b[0])
            high = min(a[3], b[3]) - max(a[1], b[1])
            if wide > 1.0 and high > 2.5:  # boxes are a little larger than letters
                pairs.append((first, second))
    return pairs
