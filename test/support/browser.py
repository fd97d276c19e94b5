"""A real browser without a window and without network: what a page looks like in it."""

import json
import re
import shutil
import subprocess
from dataclasses import dataclass, field
from html import unescape

import pytest

NAMES = ("chromium", "chromium-browser", "google-chrome", "chrome")
TIME_LIMIT = 90.0  # [s]
ATTEMPTS = 3  # on a busy machine the browser's own clock may run out before all is drawn
HEIGHT = 14000  # [pixels] of the window
OFFLINE = ("--host-resolver-rules=MAP * ~NOTFOUND", "--proxy-server=127.0.0.1:9")
FRAME = """<!DOCTYPE html><body style="margin:0"><pre id="probe"></pre>
<iframe src="{name}" style="border:0;width:{width}px;height:{height}px"></iframe><script>
onmessage = e => document.getElementById("probe").textContent = e.data;
</script></body>"""
PROBE = """<script>(() => {
const all = (of, what) => [...of.querySelectorAll(what)];
const rect = e => e.getBoundingClientRect();
const box = e => [rect(e).left, rect(e).top, rect(e).right, rect(e).bottom];
const level = t => !/rotate\\(-?[1-9]/.test(t.getAttribute("transform") || "");
const shown = e => e.checkVisibility() && rect(e).width > 0;
const drawn = svg => all(svg, "[id$=-axes_1] > g:is([id*=line2d], [id*=Collection], [id*=patch])")
  .length > 3;  // beside the background and two spines
const figures = () => all(document, "figure").map(f => {
  const svgs = all(f, "svg").filter(shown);
  return {name: f.id, caption: f.querySelector("figcaption").textContent,
    label: f.querySelector("[role=group]").getAttribute("aria-label"),
    panels: svgs.length, empty: svgs.filter(svg => !drawn(svg)).length, boxes: svgs.map(box),
    texts: svgs.map(s => all(s, "text").filter(level).map(t => [t.textContent, ...box(t)]))};
});
const letters = () => all(document, "body *").filter(e => shown(e) &&
  [...e.childNodes].some(n => n.nodeType == 3 && n.textContent.trim()));
const scale = e => e.ownerSVGElement ? e.ownerSVGElement.getScreenCTM().a : 1;
const size = e => parseFloat(getComputedStyle(e).fontSize) * scale(e);
const clicked = label => {
  const width = () => rect(label.querySelector("svg")).width;
  const before = width();
  label.click();
  const enlarged = width();
  label.click();
  return [before, enlarged, width()];
};
const report = () => ({figures: figures(),
  smallest: Math.min(...letters().map(size)),
  headings: all(document, "h1, h2, h3").map(e => +e.tagName[1]),
  fetched: performance.getEntriesByType("resource").map(e => e.name),
  width: [document.documentElement.scrollWidth, document.documentElement.clientWidth],
  clicked: all(document, "#curves label").slice(0, 1).flatMap(clicked)});
setTimeout(() => parent.postMessage(JSON.stringify(report()), "*"), 500);
matchMedia("print").addEventListener("change", e => e.matches && console.log("PRINT " +
  JSON.stringify({pictures: all(document, "figure svg").filter(shown).length,
    right: Math.max(...all(document, "body *").filter(shown).map(e => rect(e).right)),
    width: document.documentElement.clientWidth})));
})();</script>"""


@dataclass(frozen=True)
class Rendered:
    """What a browser made of a page.

    figures: with name, label, caption, number of panels, of those without data, and for each panel
    its box [pixels] and its level texts. width: of content and window [pixels]; smallest: letters
    that are shown [pixels]; headings: their levels; fetched: addresses; clicked: width of the first
    curves [pixels] before a click, after it, and after another; console: what it complains of.
    """

    figures: list = field(default_factory=list)
    width: tuple = (0, 0)
    smallest: float = 0.0
    headings: list = field(default_factory=list)
    fetched: list = field(default_factory=list)
    clicked: list = field(default_factory=list)
    console: list = field(default_factory=list)

    def figure(self, name):
        return next(entry for entry in self.figures if entry["name"] == name)


def find_browser():
    """Path of a Chromium; skips the test without one."""
    found = next(filter(None, map(shutil.which, NAMES)), None)
    if found is None:
        pytest.skip(f"no browser: none of {', '.join(NAMES)} is installed")
    return found


def render(page, folder, width=1200):
    """Load a page in a frame of a width [pixels], with a script at its end that measures it."""
    inner = _probed(page.read_text(encoding="utf-8"), folder / f"probed-{page.name}")
    outer = folder / f"frame-{page.name}"
    outer.write_text(FRAME.format(name=inner.name, width=width, height=HEIGHT))
    rendered = Rendered()
    for _ in range(ATTEMPTS):
        done = _browse(folder, outer, f"--window-size={max(width, 500)},{HEIGHT}", "--dump-dom")
        found = re.search(r'<pre id="probe">(.*?)</pre>', done.stdout, re.DOTALL)
        content = json.loads(unescape(found.group(1))) if found and found.group(1) else {}
        console = [line for line in done.stderr.splitlines() if "CONSOLE" in line]
        rendered = Rendered(**content, console=console)
        if content:
            break
    return rendered


def printed(page, folder):
    """Print a page: the PDF, and how many pictures are on paper, its width and how far to the right
    anything stands [pixels].
    """
    inner = _probed(page.read_text(encoding="utf-8"), folder / f"printed-{page.name}")
    paper = folder / f"{page.stem}.pdf"
    done = _browse(folder, inner, f"--print-to-pdf={paper}")
    return paper, json.loads(re.search(r"PRINT ({.*?})\"", done.stderr).group(1))


def _probed(text, path):
    head, _, tail = text.rpartition("</body>")
    path.write_text(f"{head}{PROBE}</body>{tail}", encoding="utf-8")
    return path


def _browse(folder, page, *options):
    command = [
        find_browser(), "--headless=new", "--no-sandbox", "--disable-gpu", *OFFLINE,
        "--enable-logging=stderr", "--v=0", f"--user-data-dir={folder / 'profile'}",
        "--virtual-time-budget=30000", *options, page.as_uri(),
    ]  # fmt: skip
    return subprocess.run(command, capture_output=True, text=True, timeout=TIME_LIMIT, check=True)


def overlapping(figure):
    """Pairs of level texts of a panel of which one covers a part of the other."""
    pairs = []
    for texts in figure["texts"]:
        seen = [entry for entry in texts if entry[0].strip()]
        for index, (first, *a) in enumerate(seen):
            for second, *b in seen[index + 1 :]:
                wide = min(a[2], b[2]) - max(a[0], b[0])
                high = min(a[3], b[3]) - max(a[1], b[1])
                if wide > 1.0 and high > 2.5:  # boxes are a little larger than letters
                    pairs.append((first, second))
    return pairs
