"""The page: what is simulated in the middle, tabs to act on it, and a line that tells."""

from __future__ import annotations

import html
import re
import threading
import time
from collections.abc import Callable
from typing import Any

import viser
from rosbags.rosbag2 import WriterError
from viser._messages import RunJavascriptMessage

from softhand_play.dropped import DROP, Dropped
from softhand_play.hand_tab import HandTab
from softhand_play.results_tab import ResultsTab
from softhand_play.scene_tab import SceneTab
from softhand_play.shots import Shot, Stage, Track
from softhand_play.strategy_tab import StrategyTab
from softhand_play.view import HandView

RATE = 10.0  # pictures a second that are sent
REFRESHED = 1.0  # time between updates of plots and words [s]
# over the picture, where it moves no button; words stay words, whatever a file puts into them
HEAD = """<div style="position: fixed; left: 5em; bottom: 0.8em; max-width: calc(100vw - 28em);
padding: 0.3em 0.7em; border-radius: 0.4em; background: rgba(255, 255, 255, 0.85);
color: black; line-height: 1.3; pointer-events: none">
<div>{}</div><div style="font-weight: bold">{}</div></div>"""
Tell = Callable[[str], None]

OWN_FOLDER = re.compile(r"\S*softhand-play-\w+/(?:\w+/)?")
TITLE = "softhand play"
CAMERA, LOOK_AT = (0.5, -0.5, 0.4), (0.0, 0.0, 0.16)  # at the start [m]
VIEW_ANGLE = 0.8  # vertical [rad]


class Page:
    """Serves a player's simulation.

    Args:
        host, port: that the server listens on.
        source: makes what is shown, given what tells a sentence.
        live: nodes run by themselves: there is nothing to choose but commands.
    """

    def __init__(
        self, host: str, port: int, source: Callable[[Tell], Any], live: bool = False
    ) -> None:
        self.server = server = viser.ViserServer(host, port, label=TITLE, verbose=False)
        server.gui.configure_theme(show_share_button=False)  # it would open a way in from outside
        server.gui.main_panel.dock_right()
        server.initial_camera.position, server.initial_camera.look_at = CAMERA, LOOK_AT
        self._sees_wall = False
        server.initial_camera.fov = VIEW_ANGLE
        _light(server)
        self._head = server.gui.add_html("")
        self.told = ""
        self.player = source(self.tell)
        self._view: HandView | None = None
        self._drawn: Track | None = None
        self._refreshed = 0.0
        self._words = "starting ..."
        self.seen: Shot | None = None
        self._closing = threading.Event()
        self.drawing = threading.Lock()  # held while widgets follow what is played
        tabs = server.gui.add_tab_group() if live else self._take_files()
        self.hand = HandTab(self, tabs.add_tab("Hand"))
        self._live = live
        if not live:
            self.scene = SceneTab(self, tabs.add_tab("Scene"))
            self.strategies = StrategyTab(self, tabs.add_tab("Strategies"))
            self.results = ResultsTab(self, tabs.add_tab("Results"))

    def _take_files(self) -> viser.GuiTabGroupHandle:
        """The button that opens files; what is dropped anywhere goes there."""
        self.dropped = Dropped(self)
        button = self.server.gui.add_upload_button("open a file, or drop it anywhere")
        button.on_upload(
            lambda event: self.attempt(
                lambda: self.dropped.open(event.target.value.name, event.target.value.content)
            )
        )
        # no public call does this; add_plotly sends its script the same way
        self.server._websock_server.queue_message(RunJavascriptMessage(source=DROP))
        return self.server.gui.add_tab_group()

    def tell(self, sentence: str) -> None:
        """Show a sentence, without the folders that dropped files are kept in."""
        self.told = OWN_FOLDER.sub("", sentence)

    def attempt(self, act: Callable[[], None]) -> None:
        """Do something that the user asked for; what cannot be is told."""
        self.tell("")
        try:
            act()
        except (ValueError, TypeError, KeyError, RuntimeError, OSError, WriterError) as error:
            self.tell(str(error))

    def run(self) -> None:
        """Serve until the page is closed."""
        while not self._closing.wait(1.0 / RATE):
            with self.drawing:
                self.refresh()

    def refresh(self) -> None:
        """Bring what is shown up to date."""
        now = self.player.now
        if now is not None:
            if now is not self._drawn:
                self._drawn = now
                self._stage()
            recorded = None if self._live else self.strategies.seen()
            shot, stage = recorded or (now.shots[-1], now.stage)
            self._draw(shot, stage)
            if time.monotonic() > self._refreshed + REFRESHED:
                self._refreshed = time.monotonic()
                self._words = self._state(shot, recorded is not None)
                self.hand.refresh()
        told = "building ..." if self.player.is_building else self.told
        self._head.content = HEAD.format(html.escape(self._words), html.escape(told))

    def _stage(self) -> None:
        """What depends on the world."""
        self._look_past(self.player.now.stage.scene.wall is not None)
        self.hand.stage()
        if not self._live:
            self.scene.stage()
            self.strategies.stage()

    def _look_past(self, wall: bool) -> None:
        """Look from the other side where a wall, which stands at +x, would hide the hand."""
        if wall != self._sees_wall:
            self._sees_wall = wall
            place = (-CAMERA[0], *CAMERA[1:]) if wall else CAMERA
            self.server.initial_camera.position = place
            for client in self.server.get_clients().values():
                client.camera.position, client.camera.look_at = place, LOOK_AT

    def _draw(self, shot: Shot, stage: Stage) -> None:
        if self._view is None or self._view.stage is not stage:
            if self._view is not None:
                self._view.remove()
            self._view = HandView(self.server, stage)
        if shot is not self.seen:
            self._view.show(shot)
            self.seen = shot

    def _state(self, shot: Shot, recorded: bool) -> str:
        player, words = self.player, [f"{shot.time:.1f} s"]
        if recorded:
            words.append("recorded")
        if shot.phase:
            words.append(f"phase {shot.phase}")
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
        self.player.close()
        with self.drawing:
            self.server.stop()


def _light(server: viser.ViserServer) -> None:
    """Two plain lights: viser's own and its surroundings that mirror cost half the frames where
    the browser draws by software.
    """
    server.scene.configure_default_lights(enabled=False, cast_shadow=False)
    server.scene.configure_environment_map(hdri=None)
    server.scene.add_light_ambient("/light/ambient", intensity=1.2)
    server.scene.add_light_directional(
        "/light/sun", intensity=2.2, position=(0.6, -0.8, 1.6), cast_shadow=False
    )
