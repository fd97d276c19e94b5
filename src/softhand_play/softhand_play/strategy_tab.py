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
from softhand_play.shots import Track, World

OUT = Path("out/play")
LIVE, RECORDED, PLAYED = "live", "recorded", "played back"
USUAL = "surface_constrained"
STANDING = (0.0, 0.0, 0.0)  # how an object rests that stands on its end [rad]


class StrategyTab:
    """Runs strategies on the player of a page."""

    def __init__(self, page: Board, tab: viser.GuiTabHandle) -> None:
        self._page, self._player, gui = page, page.player, page.server.gui
        self._track: Track | None = None
        self._since = 0.0  # wall time at which the first instant would have been shown
        with tab:
            self._strategy = gui.add_dropdown(
                "strategy", tuple(strategy_names()), initial_value=USUAL
            )
            self._as_tried = gui.add_checkbox("in the world it was tried in", True)
            run = gui.add_button("run the strategy")
            step = gui.add_button("to the end of the phase")
            go_on = gui.add_button("go on to the end")
            abort = gui.add_button("abort")
            self._words = gui.add_markdown("")
            with gui.add_folder("the run again"):
                self._shown = gui.add_dropdown("show", (LIVE, RECORDED, PLAYED))
                self._instant = gui.add_slider("instant", 0, 1, 1, 0)
                self._phase = gui.add_dropdown("phase", ("-",))
                film = gui.add_button("save a film (MP4)")
                bag = gui.add_button("save a bag")
        run.on_click(lambda _: page.attempt(self.run))
        step.on_click(lambda _: self._player.step_phase())
        go_on.on_click(lambda _: self._go_on())
        abort.on_click(lambda _: self._player.abort())
        self._shown.on_update(lambda _: self._begin())
        self._instant.on_update(lambda _: self._scrub())
        self._phase.on_update(lambda _: self.jump(self._phase.value))
        film.on_click(lambda _: page.attempt(lambda: self._save(".mp4")))
        bag.on_click(lambda _: page.attempt(lambda: self._save("")))

    def stage(self) -> None:
        """Show which strategy is to be run."""
        name = self._player.world.settings.strategy
        if name not in self._strategy.options:
            self._strategy.options = (*self._strategy.options, name)
        self._strategy.value = name

    def refresh(self) -> None:
        """A run that has ended; the next instants while it is played back."""
        self._offer()
        strategy = self._player.world.settings.strategy
        self._words.content = f"{strategy}: {self._player.phase or 'not begun'}"
        if self._shown.value == PLAYED and self._track is not None:
            gone = time.monotonic() - self._since
            last = len(self._track.shots) - 1
            self._instant.value = min(round(gone / self._track.interval), last)

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
        self._shown.value = LIVE
        self._player.run_strategy(world)

    def _go_on(self) -> None:
        self._player.stops_at_phases = self._player.paused = False

    # ---------------------------------------------------------------- the run again
    def _offer(self) -> None:
        """Phases and instants of another run."""
        if self._track is not self._page.track:
            self._track = self._page.track
            self._instant.max = max(1, len(self._track.shots) - 1)
            self._phase.options = tuple(self._track.phases) or ("-",)

    def _begin(self) -> None:
        """Go over to live, recorded or played back."""
        self._since = time.monotonic()
        if self._shown.value == LIVE or self._track is None:
            self._page.show(None)
        else:
            self._scrub()

    def _scrub(self) -> None:
        if self._track is not None and self._shown.value != LIVE:
            last = len(self._track.shots) - 1
            self._page.show(self._track.shots[min(self._instant.value, last)])

    def jump(self, phase: str) -> None:
        """Look at the instant at which a phase of the recorded run begins."""
        self._offer()
        number = self._track.phases.get(phase) if self._track is not None else None
        if number is not None:
            self._shown.value = RECORDED
            self._instant.value = number

    def _save(self, suffix: str) -> None:
        """Write a film or, without a suffix, a bag."""
        from softhand_play.recorded import film, write_bag

        if self._track is None:
            raise ValueError("run: expected one to save, got none; run a strategy first")
        path = OUT / f"{time.strftime('%Y%m%d-%H%M%S')}{suffix}"
        if suffix:
            film(self._track, path, lambda what, k, n: self._page.tell(f"{what} {k} of {n}"))
        else:
            write_bag(self._track, path)
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
