"""Files that are dropped onto the page: kept in a folder, told apart by what they say they are.

Nothing of them is run: Python files that a model names are refused, as everywhere without being
asked to.
"""

from __future__ import annotations

import re
import tempfile
from dataclasses import replace
from pathlib import Path

from grasp_strategies.strategy import load_strategy
from grasp_strategies.strategy.description import FORMAT as STRATEGY
from pneuflex_sim.scene.mesh import SUFFIXES
from pneuflex_sim.scene.objects import FORMAT as OBJECT
from pneuflex_sim.scene.scenes import FORMAT as SCENE
from softhand_bringup.bags.repair import repair
from softhand_model.documents.quoted import quoted
from softhand_model.documents.yaml_document import read_document
from softhand_model.hand.hand import FORMAT as HAND
from softhand_model.model_file import FORMAT as MODEL
from softhand_play.board import Board
from softhand_play.strategy_tab import tried_world

LARGEST = 500e6  # [bytes]
SETTING = {HAND: "hand", OBJECT: "object", SCENE: "scene", MODEL: "model"}
KINDS = (
    "a mesh (.stl, .obj), a YAML file of a hand, an object, a scene, a model or a strategy, "
    "a bag (.mcap) or results of a sweep (.jsonl)"
)

# hands what is dropped anywhere to the button that opens files
DROP = """
if (!window.softhandDrop) {
  window.softhandDrop = true;
  addEventListener("dragover", event => event.preventDefault());
  addEventListener("drop", event => {
    event.preventDefault();
    const input = document.querySelector("input[type=file]");
    if (!input || !event.dataTransfer.files.length) return;
    input.files = event.dataTransfer.files;
    input.dispatchEvent(new Event("change", {bubbles: true}));
  });
}
"""


class Dropped:
    """Opens files by what they are, on a page."""

    def __init__(self, page: Board) -> None:
        self._page = page
        self._folder = tempfile.TemporaryDirectory(prefix="softhand-play-")

    def open(self, name: str, content: bytes) -> None:
        """Open a file of this name; raises ValueError that says what is wrong with it."""
        if len(content) > LARGEST:
            raise ValueError(f"{name}: expected at most {LARGEST / 1e6:g} MB, got {len(content)}")
        folder = Path(tempfile.mkdtemp(dir=self._folder.name))
        path = folder / re.sub(r"[^\w.-]", "_", Path(name).name)
        path.write_bytes(content)
        suffix = path.suffix.lower()
        if suffix in SUFFIXES:
            self._set("object", path)
        elif suffix in (".yaml", ".yml"):
            self._open_yaml(path)
        elif suffix == ".jsonl":
            self._page.results.open_map(path)
        elif suffix == ".mcap":
            repair(folder)
            self._page.results.open_bag(folder)
        else:
            raise ValueError(f"{name}: expected {KINDS}")

    def _open_yaml(self, path: Path) -> None:
        found = read_document(path).mapping().get("format")
        kind = None if found is None else found.value
        if kind == STRATEGY:
            strategy = load_strategy(path)
            self._page.player.play(tried_world(str(path), strategy, self._page.player.world))
        elif kind in SETTING:
            self._set(SETTING[kind], path)
        else:
            raise ValueError(f"{path.name}: format: expected {KINDS}; got {quoted(kind)}")

    def _set(self, what: str, path: Path) -> None:
        """The world of now with another part; raises ValueError for an object without a place."""
        scene = self._page.player.now.stage.scene
        if what == "object" and not scene.has_object:
            raise ValueError(f"{path.name}: expected a scene with an object, got {scene.name}")
        world = self._page.player.world
        self._page.player.play(
            replace(world, settings=replace(world.settings, **{what: str(path)}))
        )
