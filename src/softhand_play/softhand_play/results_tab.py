"""The tab `Results`: a bag played, a success map whose cells run again, a diagnosis as fingers."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import viser
from numpy.typing import NDArray

from grasp_strategies.sweep.results import read_results
from grasp_strategies.sweep.success_map import SuccessMap, map_of
from grasp_strategies.sweep.trial_line import trial_of
from pneuflex_sim.scene.scenes import load_scene
from softhand_bringup.lab_story.fingers import PRESSURES, Bent, Fingers, fingers_of
from softhand_play.board import Board
from softhand_play.recorded import read_bag
from softhand_play.shots import INTERVAL, World
from softhand_play.view import HandView

Array = NDArray[np.float64]

CELL = 0.012  # side of a cell as it is drawn [m]
PLACE = (0.0, 0.45, 0.001)  # of the map's middle, beside the hand [m]
FAILED, MIXED, GRIPPED = (200, 60, 50), (235, 190, 60), (60, 150, 80)
NEEDED = {"key", "object", "cell", "replicate", "settings", "placement"}  # of a line
MAPS = Path("out/thesis")
USUAL_BAG, STORY = Path("out/demo/bag"), Path("out/lab-demo")
FINGERS = {"/before": (150, 150, 160), "/after": (240, 140, 60)}
MEASURED = (30, 30, 30)
ASIDE = np.array([0.0, -0.35, -0.1])  # of the fingers, beside the hand [m]


class ResultsTab:
    """Opens what was recorded or measured."""

    def __init__(self, page: Board, tab: viser.GuiTabHandle) -> None:
        self._page, gui = page, page.server.gui
        self._records: dict[str, Any] = {}
        self._cells: list[viser.SceneNodeHandle] = []
        self._fingers: Fingers | None = None
        self._views: list[HandView] = []
        with tab:
            with gui.add_folder("bag"):
                self._bag = gui.add_text("folder", str(USUAL_BAG))
                opened = gui.add_button("open the bag", hint="recorded with what is on stage")
            with gui.add_folder("success map"):
                self._map = gui.add_text("results", str(MAPS / "push_map" / "main"))
                loaded = gui.add_button("open the map")
                self._object = gui.add_dropdown("of the object", ("-",))
                self._replicate = gui.add_dropdown("replicate", ("-",))
                self._cell = gui.add_dropdown("cell [mm]", ("-",))
                again = gui.add_button("run this trial again")
                self._words = gui.add_markdown("or click on a cell of the map")
            with gui.add_folder("diagnosis of free bending"):
                self._diagnosis = gui.add_text("diagnosis", str(STORY / "diagnosis.json"))
                self._set = gui.add_text("measured set", str(STORY / "set"))
                bent = gui.add_button("show both fingers")
                self._pressure = gui.add_slider("step of pressure", 0, PRESSURES - 1, 1, 0)
                self._angles = gui.add_markdown("")
        bent.on_click(lambda _: page.attempt(self.open_diagnosis))
        self._pressure.on_update(lambda _: self._bend())
        opened.on_click(lambda _: page.attempt(lambda: self.open_bag(Path(self._bag.value))))
        loaded.on_click(lambda _: page.attempt(lambda: self.open_map(Path(self._map.value))))
        again.on_click(lambda _: page.attempt(lambda: self.run_cell(self._cell.value)))
        self._object.on_update(lambda _: self._draw())

    def stage(self) -> None:
        """Nothing here depends on the world."""

    def refresh(self) -> None:
        """What came out of a trial that was run again, beside what stands in the map."""

    # ---------------------------------------------------------------- bags
    def open_bag(self, folder: Path) -> None:
        """Open a bag, and look at it; raises ValueError for one that cannot be read."""
        settings, stage = self._page.player.world.settings, self._page.player.stage
        hand = stage.layout.description.name if settings.hand is None else settings.hand
        scene = load_scene(settings.scene).inclined(settings.wall_inclination)
        track = read_bag(folder, hand, settings.object, scene, INTERVAL)
        self._page.track = track
        self._page.show(track.shots[0])
        self._page.tell(f"{folder.name}: {len(track.shots)} instants; Strategies plays them")

    # ---------------------------------------------------------------- maps
    def open_map(self, path: Path) -> None:
        """Open the results of a sweep; raises ValueError where there are none."""
        records = read_results(path)
        if not records or not all(map(_is_result, records)):
            raise ValueError(f"{path}: expected results of a sweep, got others or none")
        records = [record for record in records if "outcome" in record]
        self._records = {record["key"]: record for record in records}
        names = sorted({_family(key) for key in self._records})
        self._object.options = tuple(names)
        self._object.value = names[0]
        self._draw()

    def _of_object(self) -> list[dict[str, Any]]:
        family = self._object.value
        return [record for key, record in self._records.items() if _family(key) == family]

    def _draw(self) -> None:
        """The map as squares on the ground beside the hand."""
        for handle in self._cells:
            handle.remove()
        self._cells = []
        records = self._of_object()
        if not records:
            return
        numbers = sorted({str(record["replicate"]) for record in records}, key=int)
        self._replicate.options = tuple(numbers)
        cells = {_cell(record): tuple(record["cell"]) for record in records}
        self._cell.options = tuple(cells)
        shares = {
            name: np.mean([r["outcome"] == "gripped" for r in records if _cell(r) == name])
            for name in cells
        }
        found = map_of(records)
        middle = np.mean(list(cells.values()), axis=0)
        pitch = found.pitch if isinstance(found, SuccessMap) else _pitch(list(cells.values()))
        with self._page.server.atomic():
            for name, place in cells.items():
                self._cells.append(
                    self._square(name, (np.array(place) - middle) / pitch, shares[name])
                )

    def _square(self, name: str, place: Array, share: float) -> viser.BoxHandle:
        color = GRIPPED if share >= 0.5 else MIXED if share > 0 else FAILED
        box = self._page.server.scene.add_box(
            f"/map/{name}",
            dimensions=(0.9 * CELL, 0.9 * CELL, 0.002),
            color=color,
            position=tuple(np.array(PLACE) + CELL * np.append(place, 0.0)),
            cast_shadow=False,
            receive_shadow=False,
        )
        box.on_click(lambda _: self._page.attempt(lambda: self.run_cell(name)))
        return box

    def run_cell(self, name: str) -> None:
        """Run the trial of a cell and the chosen replicate again; raises ValueError for none."""
        number = self._replicate.value
        found = [r for r in self._of_object() if _cell(r) == name and str(r["replicate"]) == number]
        if not found:
            raise ValueError(
                f"map: expected a trial in the cell {name}, got none; open a map first"
            )
        record = found[0]
        self._cell.value = name
        self._words.content = f"{record['key']}: {record['outcome']} in the map"
        try:
            settings, placement = trial_of(record)
        except (TypeError, KeyError) as reason:
            raise ValueError(f"{record['key']}: expected settings of a trial: {reason}") from reason
        settings = replace(settings, allow_effect_files=False)  # the results may be a dropped file
        self._page.player.run_strategy(World(settings, placement))

    # ---------------------------------------------------------------- diagnoses
    def open_diagnosis(self) -> None:
        """Show a finger by the model before and after; raises ValueError for other files."""
        self._fingers = fingers_of(Path(self._diagnosis.value), Path(self._set.value))
        for view in self._views:
            view.remove()
        stage = self._page.player.stage
        self._views = [
            HandView(self._page.server, replace(stage, layout=bent.layout, object=None), name, tint)
            for bent, (name, tint) in zip(self._both(), FINGERS.items(), strict=True)
        ]
        self._pressure.value = PRESSURES - 1
        self._bend()

    def _both(self) -> tuple[Bent, Bent]:
        return self._fingers.before, self._fingers.after

    def _bend(self) -> None:
        """Both fingers and the measured line at a pressure."""
        fingers, number = self._fingers, self._pressure.value
        if fingers is None:
            return
        for view, bent in zip(self._views, self._both(), strict=True):
            place = bent.states[number].wrist_position + ASIDE
            view.move(replace(bent.states[number], wrist_position=place), np.zeros(1))
        before, after = (np.degrees(bent.angles[number]) for bent in self._both())
        measured = np.degrees(fingers.measured[number])
        self._angles.content = (
            f"{1e-3 * fingers.pressures[number]:.1f} kPa: {before:.0f} deg by the model before, "
            f"{after:.0f} deg with {', '.join(fingers.effects) or 'nothing'}, {measured:.0f} deg "
            "measured (dark line)"
        )
        if np.isfinite(measured):
            self._page.server.scene.add_spline_catmull_rom(
                "/measured",
                fingers.measured_line(number) + place,
                color=MEASURED,
                thickness=4.0,
            )


def _is_result(record: Any) -> bool:
    """Whether a line is one of a sweep, as far as the map is concerned."""
    if not isinstance(record, dict) or not record.keys() >= NEEDED:
        return False
    key, cell = str(record["key"]), record["cell"]
    return key.count("/") >= 2 and isinstance(cell, list) and len(cell) == 2


def _family(key: str) -> str:
    """Plan, object and what varies: a key without cell and replicate.

    >>> _family("push_map/marker/12,-30/1")
    'push_map/marker'
    """
    return key.rsplit("/", 2)[0]


def _cell(record: dict[str, Any]) -> str:
    return record["key"].rsplit("/", 2)[1]


def _pitch(cells: list[tuple[float, float]]) -> float:
    """Least distance of cells along an axis [m]."""
    steps = [np.diff(np.unique(np.round(axis, 9))) for axis in np.array(cells).T]
    return float(min((step.min() for step in steps if len(step)), default=0.01))
