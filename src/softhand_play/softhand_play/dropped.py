"""Files dropped onto the page: stored in a temporary folder and opened by suffix and `format`.

No code of them is run: Python files that a model names are refused.
"""

from __future__ import annotations

import re
import tempfile
from dataclasses import replace
from pathlib import Path

from grasp_strategies.strategy import load_strategy
from grasp_strategies.strategy.description import FORMAT as STRATEGY
from pneuflex_sim.scene.mesh import MESH_SUFFIXES
from pneuflex_sim.scene.objects import OBJECT_FORMAT as OBJECT
from pneuflex_sim.scene.scenes import SCENE_FORMAT as SCENE
from softhand_bringup.bags.repair import repair
from softhand_common.documents.output_file import write_file
from softhand_common.documents.quoted import quoted, shortened
from softhand_common.documents.yaml_document import read_document
from softhand_model.hand.hand import FORMAT as HAND
from softhand_model.model_file import FORMAT as MODEL
from softhand_play.files import YAML
from softhand_play.page_context import PageContext
from softhand_play.strategy_tab import tried_world

SETTING = {HAND: "hand", OBJECT: "object", SCENE: "scene", MODEL: "model"}
MEASUREMENTS = (".csv", ".tsv", ".txt", ".xlsx")
ACCEPTED_FILES = (
    "a mesh (.stl, .obj), a YAML file of a hand, an object, a scene, a model or a strategy, "
    "a bag (.mcap), results of a sweep (.jsonl) or measurements (.csv, .tsv, .txt, .xlsx)"
)

# passes files that are dropped anywhere, or several that are chosen, one by one to the button
DROP_SCRIPT = """
if (!window.softhandDrop) {
  window.softhandDrop = true;
  const find = () => document.querySelector("input[type=file]");
  const give = files => [...files].forEach(file => {
    const one = new DataTransfer(), input = find();
    one.items.add(file);
    input.files = one.files;
    input.dispatchEvent(new Event("change", {bubbles: true}));
  });
  addEventListener("dragover", event => event.preventDefault());
  addEventListener("drop", event => {
    event.preventDefault();
    if (find()) give(event.dataTransfer.files);
  });
  addEventListener("click", () => { if (find()) find().multiple = true; }, true);
  addEventListener("change", event => {
    if (event.target !== find() || event.target.files.length < 2) return;
    event.stopImmediatePropagation();
    give([...event.target.files]);
  }, true);
}
"""


class Dropped:
    """Opens dropped files on a page, each according to its kind."""

    def __init__(self, page: PageContext) -> None:
        self._page = page
        self._folder = tempfile.TemporaryDirectory(prefix="softhand-play-")

    def open(self, name: str, content: bytes) -> None:
        """Open a file of this name; raises ValueError for a file that cannot be used."""
        safe = re.sub(r"[^\w.-]", "_", Path(name).name)
        suffix = Path(safe).suffix.lower()
        if suffix not in (*MESH_SUFFIXES, *YAML, *MEASUREMENTS, ".jsonl", ".mcap"):
            raise ValueError(f"{shortened(name)}: expected {ACCEPTED_FILES}")
        folder = Path(tempfile.mkdtemp(dir=self._folder.name))
        path = folder / safe
        write_file(path, content)
        if suffix in MESH_SUFFIXES:
            self._set("object", path)
        elif suffix in YAML:
            self._open_yaml(path)
        elif suffix in MEASUREMENTS:
            self._page.lab.take(path)
        elif suffix == ".jsonl":
            self._page.results.open_map(path)
        else:
            repair(folder)
            self._page.results.open_bag(folder)

    def _open_yaml(self, path: Path) -> None:
        self._page.files.check_document(path)
        found = read_document(path).mapping().get("format")
        kind = None if found is None else found.value
        if kind == STRATEGY:
            strategy = load_strategy(path)
            self._page.player.play(tried_world(str(path), strategy, self._page.player.world))
        elif kind in SETTING:
            self._set(SETTING[kind], path)
        else:
            raise ValueError(f"{path.name}: format: expected {ACCEPTED_FILES}; got {quoted(kind)}")

    def _set(self, what: str, path: Path) -> None:
        """Replace one part of the current world; raises ValueError for an object in a scene that
        has none.
        """
        scene = self._page.player.now.static_scene.scene
        if what == "object" and not scene.has_object:
            raise ValueError(f"{path.name}: expected a scene with an object, got {scene.name}")
        world = self._page.player.world
        self._page.player.play(
            replace(world, settings=replace(world.settings, **{what: str(path)}))
        )
