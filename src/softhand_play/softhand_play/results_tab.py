"""The tab `Results`: plays bags, runs cells of success maps again, shows diagnoses as fingers."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import viser

from grasp_strategies.strategy import load_strategy
from pneuflex_sim.scene.scenes import load_scene
from softhand_bringup.lab_story.fingers import PRESSURE_STEPS, Fingers, fingers_of
from softhand_common.documents.quoted import quoted
from softhand_common.numerics.arrays import Array
from softhand_play.frames import World
from softhand_play.page_context import PageContext
from softhand_play.recorded import read_bag
from softhand_play.view import HandView, wxyz
from softhand_play.widgets import NOTHING, offer
from softhand_trials.sweep.results import read_results
from softhand_trials.sweep.trial_task import trial_of

CELL_SIZE = 0.012  # side of a cell as it is drawn [m]
MAP_CENTER = np.array([-0.1, 0.36, 0.002])  # beside the hand [m]
# linear RGB, other than on the screen
FAILED_COLOR, MIXED_COLOR, GRIPPED_COLOR = (149, 11, 7), (213, 133, 11), (11, 79, 20)
SQUARE = 0.45 * CELL_SIZE * np.array([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]])
RECORD_KEYS = {"key", "object", "cell", "replicate", "settings", "placement"}  # required
FINGER_COLORS = {"before": (150, 150, 160), "after": (240, 140, 60)}
MEASURED_COLOR, LINE_THICKNESS, LINE_OFFSET = (
    (30, 30, 30),
    0.003,
    (0.0, -0.015, 0.0),
)  # thickness and place [m]
FINGERS_POSITION, FINGERS_ORIENTATION = (
    (-0.12, -0.12, -0.12),
    np.array([0.0, 0.0, 0.383, 0.924]),
)  # seen from the front


class ResultsTab:
    """The tab that opens bags, results of sweeps and diagnoses."""

    def __init__(self, page: PageContext, tab: viser.GuiTabHandle) -> None:
        self._page, gui = page, page.server.gui
        self._records: dict[str, Any] = {}
        self.places: dict[str, Array] = {}  # of the drawn cells [m]
        self._drawn: list[viser.SceneNodeHandle] = []
        self._fingers: Fingers | None = None
        self._views: list[HandView] = []
        with tab:
            look = gui.add_button("look for new files")
            look.on_click(lambda _: self.find())
            with gui.add_folder("bag"):
                self.bag = gui.add_dropdown("folder", NOTHING)
                opened = gui.add_button("open the bag", hint="hand and object must be as shown")
            with gui.add_folder("success map"):
                self.map = gui.add_dropdown("results", NOTHING)
                loaded = gui.add_button("open the map")
                self._object = gui.add_dropdown("of the object", ("-",))
                self._replicate = gui.add_dropdown("replicate", ("-",))
                self._cell = gui.add_dropdown("cell x,y [mm]", ("-",))
                again = gui.add_button("run this trial again", hint="or click on its square")
            with gui.add_folder("diagnosis of free bending"):
                self._diagnosis = gui.add_dropdown("diagnosis", NOTHING)
                self._set = gui.add_dropdown("measured set", NOTHING)
                bent = gui.add_button("show both fingers")
                self._pressure = gui.add_slider("step of pressure", 0, PRESSURE_STEPS - 1, 1, 0)
                self._angles = gui.add_markdown("")
        bent.on_click(lambda _: page.attempt(self.open_diagnosis))
        self._pressure.on_update(lambda _: self._bend())
        attempt, files = page.attempt, page.files
        opened.on_click(lambda _: attempt(lambda: self.open_bag(files.bag(self.bag.value))))
        loaded.on_click(lambda _: attempt(lambda: self.open_map(files.results(self.map.value))))
        again.on_click(lambda _: page.attempt(lambda: self.run_cell(self._cell.value)))
        self._object.on_update(lambda _: page.attempt(self._draw))
        self._cell.on_update(lambda _: self._mark())
        self.find()

    def find(self) -> None:
        """List the files that can be opened."""
        found = self._page.files.find()
        offer(self.bag, found.bags)
        offer(self.map, found.maps)
        offer(self._diagnosis, found.diagnoses)
        offer(self._set, found.sets)

    # ---------------------------------------------------------------- bags
    def open_bag(self, folder: Path) -> None:
        """Play a bag back; raises ValueError for one that cannot be read."""
        settings = self._page.player.world.settings
        hand = settings.hand or load_strategy(settings.strategy).hand
        scene = load_scene(settings.scene).inclined(settings.wall_inclination)
        track = read_bag(folder, hand, settings.object, scene)
        self._page.strategies.play(track)
        self._page.report(
            f"{folder.name}: {track.frames[-1].time:.1f} s, played back in Strategies"
        )

    # ---------------------------------------------------------------- maps
    def open_map(self, path: Path) -> None:
        """Open the results of a sweep; raises ValueError for a file without results."""
        records = read_results(path, RECORD_KEYS)
        mapped = all(each["key"].count("/") >= 2 for each in records)
        if not mapped or not any("outcome" in each for each in records):
            raise ValueError(
                f"{path}: expected results of a sweep, got none; `softhand sweep` makes them"
            )
        self._records = {record["key"]: record for record in records if "outcome" in record}
        self._object.options = tuple(sorted({_family(key) for key in self._records}))
        self._draw()
        self._page.report("green: gripped, yellow: gripped at times, red: never; click on a square")

    def _of_object(self) -> list[dict[str, Any]]:
        family = self._object.value
        return [record for key, record in self._records.items() if _family(key) == family]

    def _draw(self) -> None:
        """Draw the map as squares on the ground beside the hand."""
        records = self._of_object()
        if not records:
            return
        gripped: dict[str, list[bool]] = {}
        for record in records:
            gripped.setdefault(_cell(record), []).append(record["outcome"] == "gripped")
        cells = {_cell(record): record["cell"] for record in records}
        at = np.array(list(cells.values()), float)
        places = MAP_CENTER + CELL_SIZE * np.pad(
            (at - at.mean(axis=0)) / _pitch(at), ((0, 0), (0, 1))
        )
        self.places = dict(zip(cells, places, strict=True))
        self._replicate.options = sorted({str(record["replicate"]) for record in records}, key=int)
        self._cell.options = tuple(cells)
        for handle in self._drawn:
            handle.remove()
        scene, shares = self._page.server.scene, [np.mean(gripped[name]) for name in cells]
        squares = scene.add_batched_meshes_simple(
            "/map/cells",
            SQUARE,
            np.array([[0, 1, 2], [0, 2, 3]]),
            batched_wxyzs=np.tile([1.0, 0.0, 0.0, 0.0], (len(places), 1)),
            batched_positions=places,
            batched_colors=np.array([_color(float(share)) for share in shares], np.uint8),
            side="double",
            lod="off",
            cast_shadow=False,
            receive_shadow=False,
        )
        squares.on_click(lambda event: self._click(tuple(cells), event.instance_index))
        front = places.max(axis=0) * (1, 0, 1) + MAP_CENTER * (0, 1, 0)
        title = f"{self._object.value}, x,y [mm]"
        label = scene.add_label("/map/title", title, position=front, anchor="top-center")
        self._drawn = [squares, label]
        self._mark()

    def _mark(self) -> None:
        """Label the chosen cell with its name."""
        place = self.places.get(self._cell.value)
        if place is not None:
            name, scene = self._cell.value, self._page.server.scene
            scene.add_label("/map/cell", name, position=place, anchor="bottom-center")

    def _click(self, names: tuple[str, ...], number: Any) -> None:
        """Run the trial of a square, given its index."""
        if number not in range(len(names)):
            self._page.report(f"square: expected one of {len(names)}, got {quoted(number)}")
            return
        self._cell.value = names[number]
        self._page.attempt(lambda: self.run_cell(names[number]))

    def run_cell(self, name: str) -> None:
        """Run the trial of a cell and the chosen replicate again.

        Raises ValueError when the map has no such trial or its settings cannot be read.
        """
        number = self._replicate.value
        found = [r for r in self._of_object() if _cell(r) == name and str(r["replicate"]) == number]
        if not found:
            raise ValueError(f"cell {name}: expected a trial in the map, got none; open a map")
        record = found[0]
        try:
            settings, placement = trial_of(record)
        except (TypeError, KeyError) as reason:
            raise ValueError(f"{record['key']}: expected settings of a trial: {reason}") from reason
        settings = replace(settings, allow_effect_files=False)  # the results may be a dropped file
        self._page.files.check_settings(settings)
        self._page.report(f"{record['key']}: {record['outcome']} in the map; it runs again")
        self._page.player.run_strategy(World(settings, placement, record["outcome"]))

    # ---------------------------------------------------------------- diagnoses
    def open_diagnosis(self) -> None:
        """Show the finger of the model before and after the diagnosis, and the measured angle.

        Raises ValueError for files that are no diagnosis and its measurements.
        """
        self._page.report("computing the fingers of the model ...")
        self._fingers = fingers = fingers_of(
            self._page.files.diagnosis(self._diagnosis.value),
            self._page.files.measurements(self._set.value),
        )
        for view in self._views:
            view.remove()
        server, static_scene = self._page.server, self._page.player.now.static_scene
        server.scene.add_frame(
            "/fingers", show_axes=False, position=FINGERS_POSITION, wxyz=wxyz(FINGERS_ORIENTATION)
        )
        self._views = [
            HandView(
                server,
                replace(static_scene, layout=bent.layout, object=None),
                f"/fingers/{name}",
                tint,
            )
            for bent, (name, tint) in zip(
                (fingers.before, fingers.after), FINGER_COLORS.items(), strict=True
            )
        ]
        self._pressure.value = PRESSURE_STEPS - 1
        self._bend()
        self._page.report("fingers of the diagnosis: left of the hand")

    def _bend(self) -> None:
        """Show both fingers and the measured line at the chosen pressure."""
        fingers, number = self._fingers, self._pressure.value
        if fingers is None:
            return
        both = fingers.before, fingers.after
        for view, bent in zip(self._views, both, strict=True):
            view.move(bent.states[number], np.zeros(1))
        before, after = (np.degrees(bent.angles[number]) for bent in both)
        measured = np.degrees(fingers.measured[number])
        self._angles.content = (
            f"{1e-3 * fingers.pressures[number]:.1f} kPa: grey, the model before: {before:.0f} deg;"
            f" orange, with {', '.join(fingers.effects) or 'nothing'}: {after:.0f} deg; dark line, "
            f"measured: {measured:.0f} deg"
        )
        self._page.server.scene.add_spline_catmull_rom(
            "/fingers/measured",
            fingers.measured_line(number)
            + fingers.before.states[number].wrist_position
            + LINE_OFFSET,
            color=MEASURED_COLOR,
            thickness=LINE_THICKNESS,
            visible=bool(np.isfinite(measured)),
        )


def _family(key: str) -> str:
    """Plan, object and varied setting of a trial: its key without cell and replicate.

    >>> _family("push_map/marker/12,-30/1")
    'push_map/marker'
    """
    return key.rsplit("/", 2)[0]


def _cell(record: dict[str, Any]) -> str:
    return record["key"].rsplit("/", 2)[1]


def _pitch(cells: Array) -> float:
    """Smallest distance of cells (k, 2) along an axis [m]."""
    steps = [np.diff(np.unique(np.round(axis, 9))) for axis in cells.T]
    return float(min((step.min() for step in steps if len(step)), default=0.01))


def _color(share: float) -> tuple[int, int, int]:
    """Color of a cell in which this share of the trials gripped."""
    return GRIPPED_COLOR if share >= 0.5 else MIXED_COLOR if share > 0 else FAILED_COLOR
