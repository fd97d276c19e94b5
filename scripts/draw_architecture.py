"""Draws the pictures of docs/understand/architecture.md (`make docs`).

The packages with their rooms, in the order of the layers in pyproject.toml, and the ways of a
command, a measurement and an effect from docs/understand/ways.yaml: lists of files, each with what
happens in it.
"""

from __future__ import annotations

import math
import sys
import textwrap
import tomllib
from pathlib import Path
from typing import Any

import yaml
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import FancyBboxPatch

from softhand_common.documents.output_file import save_figure

ROOT = Path(__file__).parents[1]
WAYS = ROOT / "docs" / "understand" / "ways.yaml"
OUT = ROOT / "docs" / "figures" / "architecture"
TOPIC = "topic"  # a step between two processes
COLOURS = {
    "softhand_common": "#f5f5f5",
    "softhand_model": "#d5e8d4",
    "pneuflex_sim": "#dae8fc",
    "softhand_design": "#e8f0d8",
    "pneumaticbox_driver": "#ffe6cc",
    "grasp_strategies": "#fff2cc",
    "softhand_trials": "#fbe8b8",
    "model_lab": "#e1d5e7",
    "softhand_ros": "#f5f5f5",
    "softhand_bringup": "#f8cecc",
    "softhand_gym": "#e0e8c8",
    "softhand_play": "#d0e0e3",
}
PLACES = {  # left edge, lower edge, width, height
    "softhand_play": (0.0, 9.9, 12.0, 1.2),
    "softhand_bringup": (0.0, 8.6, 7.4, 1.2),
    "softhand_gym": (7.5, 8.6, 4.5, 1.2),
    "softhand_trials": (3.0, 7.3, 2.8, 1.2),
    "softhand_ros": (0.0, 0.0, 2.8, 8.5),
    "grasp_strategies": (3.0, 5.0, 2.8, 2.2),
    "softhand_design": (6.1, 5.4, 2.8, 3.1),
    "pneuflex_sim": (3.0, 2.3, 2.8, 2.6),
    "pneumaticbox_driver": (6.1, 2.3, 2.8, 3.0),
    "model_lab": (9.2, 2.3, 2.8, 6.2),
    "softhand_model": (3.0, 1.0, 9.0, 1.2),
    "softhand_common": (3.0, 0.0, 9.0, 0.9),
}
LINE = 0.36  # from one room to the next below
COLUMN_LETTERS = 32  # that fit into a box of the usual width


def rooms() -> dict[str, list[str]]:
    """Rooms of each package, uppermost layer first; top-level modules go without a slash."""
    found = {}
    contracts = tomllib.loads((ROOT / "pyproject.toml").read_text())["tool"]["importlinter"]
    orders: dict[str, list[str]] = {}
    for contract in contracts["contracts"]:
        for package in contract.get("containers", []):
            layers = [part.strip(" ()") for layer in contract["layers"] for part in _parts(layer)]
            orders[package] = layers
    for package in COLOURS:
        folder = ROOT / "src" / package / package
        names = [f"{p.name}/" for p in folder.iterdir() if (p / "__init__.py").exists()]
        names += [p.stem for p in folder.glob("*.py") if not p.stem.startswith("__")]
        order = orders.get(package, [])
        place = {name: order.index(name.strip("/")) for name in names if name.strip("/") in order}
        found[package] = sorted(names, key=lambda name: (place.get(name, len(order)), name))
    return found


def _parts(layer: str) -> list[str]:
    return layer.replace(":", "|").split("|")


def box(axes: Axes, place: tuple[float, float, float, float], colour: str) -> None:
    """A rounded box."""
    x, y, width, height = place
    axes.add_patch(
        FancyBboxPatch(
            (x + 0.06, y + 0.06),
            width - 0.12,
            height - 0.12,
            boxstyle="round,pad=0.02,rounding_size=0.08",
            facecolor=colour,
            edgecolor="#555555",
            linewidth=0.8,
        )
    )


def draw_packages() -> Figure:
    """Packages and their rooms: what stands above may import what stands below."""
    figure = Figure(figsize=(12.0, 11.1))
    axes = figure.add_axes((0.01, 0.01, 0.98, 0.98))
    axes.set(xlim=(0, 12), ylim=(0, 11.1))
    axes.axis("off")
    for package, names in rooms().items():
        x, y, width, height = PLACES[package]
        top = y + height - 0.33
        box(axes, PLACES[package], COLOURS[package])
        axes.text(x + 0.2, top, package, weight="bold", fontsize=12)
        lines = _in_lines(names, int(width)) if width > 3.0 else _in_columns(names, height)
        for number, line in enumerate(lines, 1):
            axes.text(x + 0.2, top - number * LINE, line, fontsize=10.5)
    return figure


def _in_lines(names: list[str], beside: int) -> list[str]:
    """Names beside each other, so many in a line."""
    return ["    ".join(names[k : k + beside]) for k in range(0, len(names), beside)]


def _in_columns(names: list[str], height: float) -> list[str]:
    """Names one below the other, several in a line where there are too many."""
    a_line = math.ceil(len(names) / int((height - 0.4) / LINE))
    lines = [", ".join(names[k : k + a_line]) for k in range(0, len(names), a_line)]
    fits = max(map(len, lines)) <= COLUMN_LETTERS
    return lines if fits else textwrap.wrap(", ".join(names), COLUMN_LETTERS)


def draw_way(steps: list[dict[str, str]]) -> Figure:
    """A way as files one below the other, coloured by package, each with what happens in it."""
    figure = Figure(figsize=(11.0, 0.45 * len(steps) + 0.3))
    axes = figure.add_axes((0.01, 0.01, 0.98, 0.98))
    axes.set(xlim=(0, 11), ylim=(-len(steps), 0.2))
    axes.axis("off")
    for number, step in enumerate(steps):
        y, (what, words) = -number - 1.0, next(iter(step.items()))
        if what == TOPIC:
            axes.text(0.5, y + 0.5, f"~ {words} ~", va="center", fontsize=10, style="italic")
            continue
        package = what.partition("/")[0]
        box(axes, (0.0, y, 4.9, 1.0), COLOURS[package])
        axes.text(0.2, y + 0.5, what, va="center", fontsize=10)
        axes.text(5.1, y + 0.5, words, va="center", fontsize=10)
    return figure


def ways() -> dict[str, Any]:
    """The ways by name, each a list of steps {file or `topic`: what happens}."""
    found: dict[str, Any] = yaml.safe_load(WAYS.read_text())
    return found


def main() -> int:
    """Draw all pictures, and say how many files each way has."""
    OUT.mkdir(parents=True, exist_ok=True)
    save_figure(draw_packages(), OUT / "packages.png", dpi=80)
    for name, steps in ways().items():
        save_figure(draw_way(steps), OUT / f"{name}.png", dpi=80)
        print(f"{name}: {sum(TOPIC not in step for step in steps)} files")
    return 0


if __name__ == "__main__":
    sys.exit(main())
