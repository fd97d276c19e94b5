"""The tab `Strategies`: run one, phase by phase, look at the run again, save it."""

from __future__ import annotations

import time
from dataclasses import replace
from pathlib import Path

import viser

from grasp_strategies.strategy import Strategy, load_strategy, strategy_names
from grasp_strategies.trials import Placement, TrialSettings
from pneuflex_sim.scene.objects import load_object
from softhand_play.board import Board
from softhand_play.shots import INTERVAL, Shot, Stage, Track, World

OUT = Path("out/play")
LIVE, RECORDED, PLAYED = "live", "recorded", "played back"
NO_PHASE = "-"
STANDING = (0.0, 0.0, 0.0)  # how an object rests that stands on its end [rad]


class StrategyTab:
    """Runs strategies on the player of a page."""

    def __init__(self, page: Board, tab: viser.GuiTabHandle) -> None:
        self._page, self._player, gui = page, page.player, page.server.gui
        self._offered: Track | None = None
        self._since = 0.0  # wall time at which the first instant would have been shown
        with tab:
            self._strategy = gui.add_dropdown("strategy", tuple(strategy_names()))
            self._as_tried = gui.add_checkbox("in the world it was tried in", True)
            run = gui.add_button("run the strategy")
            step = gui.add_button("next phase")
            go_on = gui.add_button("go on to the end")
            abort = gui.add_button("abort")
            with gui.add_folder("the run again"):
                self._shown = gui.add_dropdown("show", (LIVE, RECORDED, PLAYED))
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
        self.stage()

    def stage(self) -> None:
        """Show which strategy is to be run, and what goes on."""
        name = self._player.world.settings.strategy
        if name not in self._strategy.options:
            self._strategy.options = (*self._strategy.options, name)
        self._strategy.value = name
        self._shown.value = LIVE

    # ---------------------------------------------------------------- running
    def run(self) -> None:
        """Run the chosen strategy from the start of its world."""
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
        """Run to the end of the phase; the first one if the strategy does not run."""
        if not self._player.is_running:
            self.run()
        self._player.stops_at_phases, self._player.paused = True, False

    def _go_on(self) -> None:
        self._player.stops_at_phases = self._player.paused = False

    # ---------------------------------------------------------------- the run again
    def seen(self) -> tuple[Shot, Stage] | None:
        """The instant of the recorded run that is looked at, and its stage; None: what goes on."""
        track = self._player.track
        if track is not None and track is not self._offered:
            self._offer(track)
        if track is None or self._shown.value == LIVE:
            return None
        last = len(track.shots) - 1
        if self._shown.value == PLAYED:
            gone = round((time.monotonic() - self._since) / INTERVAL)
            self._time.value = INTERVAL * min(gone, last)
        return track.shots[min(round(self._time.value / INTERVAL), last)], track.stage

    def _offer(self, track: Track) -> None:
        """Phases and length of another run."""
        self._offered = track
        self._phase.options = (NO_PHASE, *track.phases)
        self._time.value = 0.0
        self._time.max = max(1, len(track.shots) - 1) * INTERVAL

    def play(self, track: Track) -> None:
        """Play a run back."""
        self._player.track = track
        self._shown.value = LIVE
        self._shown.value = PLAYED

    def _pull(self, event: viser.GuiEvent) -> None:
        if event.client is not None:  # a user, not the playing
            self._shown.value = RECORDED

    def jump(self, phase: str) -> None:
        """Look at the instant at which a phase of the recorded run begins."""
        track = self._player.track
        if track is not None and phase in track.phases:
            self.look_at(track.phases[phase])

    def look_at(self, number: int) -> None:
        """Look at an instant of the recorded run, by its number."""
        self._shown.value = RECORDED
        self._time.value = INTERVAL * number

    def save(self, suffix: str) -> None:
        """Write a film or, without a suffix, a bag."""
        from softhand_play.recorded import film, write_bag

        track = self._player.track
        if track is None:
            raise ValueError("run: expected one to save, got none; run a strategy first")
        path = OUT / f"{time.strftime('%Y%m%d-%H%M%S')}{suffix}"
        if suffix:
            film(track, path, lambda what, k, n: self._page.tell(f"film: {what} {k} of {n}"))
        else:
            write_bag(track, path)
        self._page.tell(f"saved: {path}")


def tried_world(name: str, strategy: Strategy, world: World) -> World:
    """The world that a strategy was tried in, with the object of `world` if it is known to lift
    that, else with the first that it lifts.
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
    )
    place = tried.place
    if place is None:
        found = load_object(chosen)
        place = (found if upright is None else replace(found, rpy=upright)).corner_place
    return World(settings, Placement(place))
