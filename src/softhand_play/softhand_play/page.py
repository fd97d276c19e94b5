"""The page: a view of the hand, tabs to command it, and a line of messages."""

from __future__ import annotations

import re
import sys
import threading
import time
import traceback
from collections.abc import Callable, Iterable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import numpy as np
import viser
from rosbags.rosbag2 import WriterError

from pneuflex_sim.scene.scenes import SceneDescription
from softhand_common.numerics.rotations import from_rpy, rotate
from softhand_play.dropped import DROP_SCRIPT, Dropped
from softhand_play.files import AllowedFiles
from softhand_play.frames import Frame, StaticScene, Track
from softhand_play.hand_tab import HandTab
from softhand_play.lab_tab import LabTab
from softhand_play.messages import Look, Report, status_html
from softhand_play.page_layout import layout_script
from softhand_play.page_server import PageServer
from softhand_play.player import INPUT_ERRORS
from softhand_play.results_tab import ResultsTab
from softhand_play.scene_tab import SceneTab
from softhand_play.strategy_tab import StrategyTab
from softhand_play.view import HandView

FRAME_RATE = 10.0  # frames sent to browsers [1/s]
REFRESH_PERIOD = 1.0  # time between updates of plots and status line [s]

OWN_FOLDER = re.compile(r"\S*softhand-play-\w+/(?:\w+/)?")
TITLE = "Softhand Play"
CAMERA_POSITION, LOOK_AT = (0.5, -0.5, 0.4), (0.0, 0.0, 0.16)  # of the initial view [m]
MIDDLE_OF_HAND = (0.0, 0.0, 0.1)  # in the wrist's frame [m]
VIEW_ANGLE = 0.8  # vertical [rad]


class Page:
    """The page that shows and commands a `Source`.

    Args:
        host, port: address and port on which the server listens.
        source: makes the source of the frames; called with a function that shows a sentence.
        live: whether the source is running nodes, so that only the tab `Hand` is shown.
        folders: folders whose files the page may open, besides `out`.

    Raises the errors of `PageServer`.
    """

    def __init__(
        self,
        host: str,
        port: int,
        source: Callable[[Report], Any],
        live: bool = False,
        folders: Iterable[Path] = (),
    ) -> None:
        self.message = self._refusal = ""
        self.look = Look.PLAIN  # of the message
        self.server = server = PageServer(host, port, TITLE, self._refuse, self._accept)
        self.files = AllowedFiles(folders)
        server.gui.configure_theme(show_share_button=False)  # sharing would give others access
        server.gui.main_panel.dock_right()
        server.initial_camera.position, server.initial_camera.look_at = CAMERA_POSITION, LOOK_AT
        self._view_from = (*CAMERA_POSITION, *LOOK_AT)
        server.initial_camera.fov = VIEW_ANGLE
        _light(server)
        self._head = server.gui.add_html("")
        server.run_script(layout_script(TITLE))
        self.player = source(self.report)
        self.player.is_watched = lambda: bool(server.get_clients())
        self._view: HandView | None = None
        self._drawn: Track | None = None
        self._refreshed = 0.0
        self._status = "starting ..."
        self.seen: Frame | None = None
        self._closing = threading.Event()
        self.drawing = threading.Lock()  # held while the widgets are updated
        tabs = server.gui.add_tab_group() if live else self._take_files()
        self.live = live
        self.hand = HandTab(self, tabs.add_tab("Hand"))
        if not live:
            self.scene = SceneTab(self, tabs.add_tab("Scene"))
            self.strategies = StrategyTab(self, tabs.add_tab("Strategies"))
            self.results = ResultsTab(self, tabs.add_tab("Results"))
            self.lab = LabTab(self, tabs.add_tab("Lab"))

    def _take_files(self) -> viser.GuiTabGroupHandle:
        """Add the button that opens files, which also gets files dropped anywhere on the page."""
        self.dropped, self._opening = Dropped(self), ThreadPoolExecutor(1)
        self.server.gui.add_upload_button("open a file, or drop it anywhere")
        self.server.uploaded = self._open
        self.server.run_script(DROP_SCRIPT)
        return self.server.gui.add_tab_group()

    def _open(self, file: viser.UploadedFile) -> None:
        """Open a file after those that came before it, in a thread."""
        self._opening.submit(self.attempt, lambda: self.dropped.open(file.name, file.content))

    def report(self, sentence: str, look: Look = Look.PLAIN) -> None:
        """Show a sentence; paths of the temporary folders of dropped files are left out."""
        self.message, self.look = OWN_FOLDER.sub("", sentence), look

    def attempt(self, act: Callable[[], None]) -> None:
        """Carry out a request of the user; when it fails, the error is shown."""
        self.report("")
        try:
            act()
        except (*INPUT_ERRORS, WriterError) as error:
            self.report(str(error), Look.ERROR)

    def _refuse(self, sentence: str) -> None:
        """Show and log why a message of a browser was refused."""
        self._refusal = sentence
        self.report(sentence, Look.ERROR)
        print(f"softhand-play: refused: {sentence}", file=sys.stderr, flush=True)

    def _accept(self) -> None:
        """A value has been accepted: remove the message about a refused one."""
        if self._refusal and self.message == self._refusal:
            self.report("")

    def run(self) -> None:
        """Serve until the page is closed; repeated errors of drawing are shown and logged once."""
        failed = ""
        while not self._closing.wait(1.0 / FRAME_RATE):
            with self.drawing:
                try:
                    self.refresh()
                except INPUT_ERRORS as error:  # other parts of the page still work
                    sentence = f"cannot be shown: {type(error).__name__}: {error}"
                    if sentence != failed:
                        failed = sentence
                        traceback.print_exc()
                        self.report(sentence, Look.ERROR)

    def refresh(self) -> None:
        """Show the newest frame, or the chosen one of a recorded run."""
        now = self.player.now
        if now is not None:
            if now is not self._drawn:
                self._drawn = now
                self._show_world()
            recorded = None if self.live else self.strategies.seen()
            frame, static_scene = recorded or (now.frames[-1], now.static_scene)
            self._draw(frame, static_scene)
            if time.monotonic() > self._refreshed + REFRESH_PERIOD:
                self._refreshed = time.monotonic()
                self._status = self._status_of(frame, recorded is not None)
                self.hand.refresh()
        building = self.player.is_building
        message, look = ("building ...", Look.PLAIN) if building else (self.message, self.look)
        self._head.content = status_html(self._status, message, look)

    def _show_world(self) -> None:
        """Update everything that depends on the world."""
        self._look_at(self.player.now.static_scene.scene)
        self.hand.show_world()
        if not self.live:
            self.scene.show_world()
            self.strategies.show_world()

    def _look_at(self, scene: SceneDescription) -> None:
        """Put the camera before a table, on the other side if there is a wall, which at +x would
        hide the hand, and before the hand where nothing but it is there.
        """
        place, seen = np.array(CAMERA_POSITION), np.array(LOOK_AT)
        if scene.wall is not None:
            place[0] = -place[0]
        if scene.rigid_wrist:
            middle = rotate(from_rpy(scene.wrist_rpy), MIDDLE_OF_HAND)
            shift = np.array(scene.wrist_position) + middle - seen
            place, seen = place + shift, seen + shift
        if (*place, *seen) == self._view_from:
            return
        self._view_from = (*place, *seen)
        self.server.initial_camera.position = tuple(place)
        self.server.initial_camera.look_at = tuple(seen)
        for client in self.server.get_clients().values():
            client.camera.position, client.camera.look_at = tuple(place), tuple(seen)

    def _draw(self, frame: Frame, static_scene: StaticScene) -> None:
        if self._view is None or self._view.static_scene is not static_scene:
            if self._view is not None:
                self._view.remove()
            self._view = HandView(self.server, static_scene)
        if frame is not self.seen:
            self._view.show(frame)
            self.seen = frame

    def _status_of(self, frame: Frame, recorded: bool) -> str:
        player, words = self.player, [f"{frame.time:.1f} s"]
        if recorded:
            words.append("recorded")
        if frame.phase:
            words.append(f"phase {frame.phase}")
        if player.paused:
            words.append("paused")
        elif player.pace.is_slow:
            words.append(f"slower than real time: {player.pace.measured:.2f} times")
        elif player.pace.speed < 1.0:
            words.append(f"slow motion: {player.pace.speed:g} times real time")
        return ", ".join(words)

    def close(self) -> None:
        """End simulation and server."""
        self._closing.set()
        if not self.live:
            self._opening.shutdown()
            self.lab.close()
        self.player.close()
        with self.drawing:
            self.server.stop()


def _light(server: viser.ViserServer) -> None:
    """Two plain lights: viser's default lights and environment map halve the frame rate in a
    browser that renders without a graphics card.
    """
    server.scene.configure_default_lights(enabled=False, cast_shadow=False)
    server.scene.configure_environment_map(hdri=None)
    server.scene.add_light_ambient("/light/ambient", intensity=1.2)
    server.scene.add_light_directional(
        "/light/sun", intensity=2.2, position=(0.6, -0.8, 1.6), cast_shadow=False
    )
