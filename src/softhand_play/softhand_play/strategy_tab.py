"""The tab `Strategies`: runs a strategy, also phase by phase, replays the run and saves it."""

from __future__ import annotations

import time
from dataclasses import replace
from pathlib import Path

import viser

from grasp_strategies.strategy import Strategy, load_strategy, strategy_names
from pneuflex_sim.scene.objects import load_object
from softhand_play.frames import INTERVAL, Frame, StaticScene, Track, World
from softhand_play.messages import Look
from softhand_play.page_context import PageContext
from softhand_trials.trials import Placement, TrialSettings

PLAY_FOLDER = Path("out/play")
SHOW_LIVE, SHOW_RECORDED, SHOW_PLAYED = "live", "recorded", "played back"
NO_PHASE = "-"
STANDING = (0.0, 0.0, 0.0)  # roll, pitch, yaw of an object that stands on its end [rad]


class StrategyTab:
    """The tab that runs strategies in the world of the page's player."""

    def __init__(self, page: PageContext, tab: viser.GuiTabHandle) -> None:
        self._page, self._player, gui = page, page.player, page.server.gui
        self._offered: Track | None = None
        self._since = 0.0  # wall time at which the playback started
        with tab:
            self._strategy = gui.add_dropdown("strategy", tuple(strategy_names()))
            self._as_tried = gui.add_checkbox("in the world it was tried in", True)
            run = gui.add_button("run the strategy")
            step = gui.add_button("next phase")
            go_on = gui.add_button("go on to the end")
            abort = gui.add_button("abort")
            with gui.add_folder("the run again"):
                self._shown = gui.add_dropdown("show", (SHOW_LIVE, SHOW_RECORDED, SHOW_PLAYED))
                self._time = gui.add_slider("time [s]", 0.0, INTERVAL, INTERVAL, 0.0)
                self._phase = gui.add_dropdown("phase", (NO_PHASE,))
                film = gui.add_button("save a film (MP4)")
                bag = gui.add_button("save a bag")
        run.on_click(lambda _: page.attempt(self.run))
        step.on_click(lambda _: page.attempt(self._step))
        go_on.on_click(lambda _: self._go_on())
        abort.on_click(lambda _: self._player.abort())
        self._shown.on_update(lambda _: setattr(self, "_since", time.monotonic()))
        self._time.on_update(self._pull)
        self._phase.on_update(lambda _: self.jump(self._phase.value))
        film.on_click(lambda _: page.attempt(lambda: self.save(".mp4")))
        bag.on_click(lambda _: page.attempt(lambda: self.save("")))
        self.show_world()

    def show_world(self) -> None:
        """Select the strategy of the world, and show the live view."""
        name = self._player.world.settings.strategy
        if name not in self._strategy.options:
            self._strategy.options = (*self._strategy.options, name)
        self._strategy.value = name
        self._shown.value = SHOW_LIVE

    # ---------------------------------------------------------------- running
    def run(self) -> None:
        """Run the chosen strategy in the world it was tried in, or in the current one."""
        strategy = load_strategy(self._strategy.value)
        world = self._player.world
        if self._as_tried.value:
            world = tried_world(self._strategy.value, strategy, world)
        else:
            settings = replace(world.settings, strategy=self._strategy.value, hand=None)
            world = World(settings, world.placement)
        self._player.stops_at_phases = False
        self._player.run_strategy(world)

    def _step(self) -> None:
        """Run to the end of the current phase, or of the first one if no strategy runs."""
        if not self._player.is_running:
            self.run()
        self._player.stops_at_phases, self._player.paused = True, False

    def _go_on(self) -> None:
        self._player.stops_at_phases = self._player.paused = False

    # ---------------------------------------------------------------- the run again
    def seen(self) -> tuple[Frame, StaticScene] | None:
        """The chosen frame of the recorded run and its static scene; None for the live view."""
        track = self._player.track
        if track is not None and track is not self._offered:
            self._offer(track)
        if track is None or self._shown.value == SHOW_LIVE:
            return None
        last = len(track.frames) - 1
        if self._shown.value == SHOW_PLAYED:
            gone = round((time.monotonic() - self._since) / INTERVAL)
            self._time.value = INTERVAL * min(gone, last)
        return track.frames[min(round(self._time.value / INTERVAL), last)], track.static_scene

    def _offer(self, track: Track) -> None:
        """Let the user choose among the phases and times of a new run."""
        self._offered = track
        self._phase.options = (NO_PHASE, *track.phases)
        self._time.value = 0.0
        self._time.max = max(1, len(track.frames) - 1) * INTERVAL

    def play(self, track: Track) -> None:
        """Play a run back."""
        self._player.track = track
        self._shown.value = SHOW_LIVE
        self._shown.value = SHOW_PLAYED

    def _pull(self, event: viser.GuiEvent) -> None:
        if event.client is not None:  # a user, not the playing
            self._shown.value = SHOW_RECORDED

    def jump(self, phase: str) -> None:
        """Show the first frame of a phase of the recorded run."""
        track = self._player.track
        if track is not None and phase in track.phases:
            self.look_at(track.phases[phase])

    def look_at(self, number: int) -> None:
        """Show a frame of the recorded run, given its index."""
        self._shown.value = SHOW_RECORDED
        self._time.value = INTERVAL * number

    def save(self, suffix: str) -> None:
        """Write the recorded run as a film or, with an empty suffix, as a bag."""
        from softhand_play.recorded import film, write_bag

        track = self._player.track
        if track is None:
            raise ValueError("run: expected a recorded run to save, got none; run a strategy first")
        path = PLAY_FOLDER / f"{time.strftime('%Y%m%d-%H%M%S')}{suffix}"
        if suffix:
            film(track, path, lambda what, k, n: self._page.report(f"film: {what} {k} of {n}"))
        else:
            write_bag(track, path)
        self._page.report(f"saved: {path}", Look.SUCCESS)
        self._page.results.find()


def tried_world(name: str, strategy: Strategy, world: World) -> World:
    """The world in which a strategy was tried, with the object of `world` if it is one of the
    strategy's objects, else with the first of them.
    """
    tried, known = strategy.tried_with, strategy.objects
    chosen = world.settings.object
    if known and chosen not in known:
        chosen = known[0]
    upright = STANDING if chosen in tried.upright else None
    settings = TrialSettings(
        strategy=name,
        object=chosen,
        scene=tried.scene,
        model=tried.model or None,
        segments=tried.segments,
        wall_inclination=tried.wall_inclination,
        object_rpy=upright,
        engine=world.settings.engine,
    )
    place = tried.place
    if place is None:
        found = load_object(chosen)
        place = (found if upright is None else replace(found, rpy=upright)).corner_place
    return World(settings, Placement(place))
