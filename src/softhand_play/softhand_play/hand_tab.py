"""The tab `Hand`: sliders of the channels, plots of the last seconds, wrist, pause, pace."""

from __future__ import annotations

import numpy as np
import viser
from numpy.typing import NDArray
from viser import uplot

from softhand_play.board import Board
from softhand_play.shots import Shot
from softhand_play.view import wxyz

Array = NDArray[np.float64]

PRESSURE, AIR_MASS = "pressure [kPa]", "air mass [mg]"
SCALE = {PRESSURE: 1e3, AIR_MASS: 1e-6}  # of the sliders, in Pa and kg
PLOTS = {PRESSURE: ("pressures", 1e3), AIR_MASS: ("masses", 1e-6), "volume [ml]": ("volumes", 1e-6)}
PLOT_HEIGHT = 130  # [pixels]
PACES = {"real time": 1.0, "1/2": 0.5, "1/5": 0.2, "1/10": 0.1}
EACH = 4  # instant in the plots
STEPS = 200  # of a slider
COLORS = ("#1f77b4", "#ff7f0e", "#2ca02c", "#d62728", "#9467bd", "#8c564b", "#e377c2", "#7f7f7f")


class HandTab:
    """Acts on the player of a page."""

    def __init__(self, page: Board, tab: viser.GuiTabHandle) -> None:
        self._page, self._player, gui = page, page.player, page.server.gui
        self._tab, self._sliders, self._plots = tab, [], {}
        self._folder: viser.GuiFolderHandle | None = None
        self._handle: viser.TransformControlsHandle | None = None
        with tab:
            self._quantity = gui.add_dropdown("command", (PRESSURE, AIR_MASS))
            self._pause = gui.add_checkbox("pause", False)
            self._pace = gui.add_dropdown("pace", tuple(PACES), visible=page.player.keeps_pace)
            self._reset = gui.add_button("reset")
        self._quantity.on_update(lambda _: self.stage())
        self._pause.on_update(lambda _: setattr(self._player, "paused", self._pause.value))
        self._pace.on_update(self._set_pace)
        self._reset.on_click(lambda _: self._player.reset())

    def _set_pace(self, _: viser.GuiEvent) -> None:
        self._player.pace.speed = PACES[self._pace.value]
        self._player.pace.anchor(self._player.shots[-1].time)

    # ---------------------------------------------------------------- a new world
    def stage(self) -> None:
        """Sliders and plots for the channels of the hand."""
        if self._folder is not None:
            self._folder.remove()
        gui, hand = self._page.server.gui, self._player.stage.layout.description
        limits = hand.max_pressures()
        if self._quantity.value == AIR_MASS:
            from pneuflex_sim.pictures.hand_picture import air_masses_at  # matplotlib takes 1 s

            limits = air_masses_at(hand, limits)
        with self._tab:
            self._folder = gui.add_folder("channels")
        with self._folder:
            self._sliders = [
                self._slider(k, name, limits[k] / SCALE[self._quantity.value])
                for k, name in enumerate(self._player.stage.channels)
            ]
            self._plots = {title: self._plot(title, self._player.stage.channels) for title in PLOTS}
        self._place_handle()

    def _slider(self, channel: int, name: str, limit: float) -> viser.GuiSliderHandle:
        top = float(f"{limit:.3g}")
        slider = self._page.server.gui.add_slider(
            f"channel {name}",
            0.0,
            top,
            top / STEPS,
            0.0,
            hint=f"0 to {top:g} {self._quantity.value}",
        )
        slider.on_update(lambda _: self._command(channel))
        return slider

    def _command(self, channel: int) -> None:
        wanted = np.full(len(self._sliders), np.nan)
        quantity = self._quantity.value
        wanted[channel] = self._sliders[channel].value * SCALE[quantity]
        if quantity == PRESSURE:
            self._player.command_pressures(wanted)
        else:
            self._player.command_masses(wanted)

    def _plot(self, title: str, channels: tuple[str, ...]) -> viser.GuiUplotHandle:
        series = [
            uplot.Series(label=name, stroke=COLORS[k % len(COLORS)], width=2)
            for k, name in enumerate(channels)
        ]
        empty = tuple(np.zeros(1) for _ in range(len(channels) + 1))
        return self._page.server.gui.add_uplot(
            empty,
            (uplot.Series(label="time [s]"), *series),
            title=title,
            scales={"x": uplot.Scale(time=False)},
            height=PLOT_HEIGHT,
        )

    def _place_handle(self) -> None:
        """The handle at the wrist; none where the wrist is fixed."""
        if self._handle is not None:
            self._handle.remove()
            self._handle = None
        stage = self._player.stage
        if stage.scene.rigid_wrist:
            return
        wrist = self._player.shots[-1].state
        self._handle = self._page.server.scene.add_transform_controls(
            "/wrist_handle",
            scale=0.08,
            position=wrist.wrist_position,
            wxyz=wxyz(wrist.wrist_orientation),
        )
        self._handle.on_update(self._move)

    def _move(self, event: viser.TransformControlsEvent) -> None:
        place, turn = event.target.position, np.roll(event.target.wxyz, -1)
        self._player.command_wrist(np.array(place), np.array(turn))

    # ---------------------------------------------------------------- while it runs
    def refresh(self) -> None:
        """The plots of the last seconds; the handle follows a strategy."""
        if self._pause.value != self._player.paused:
            self._pause.value = self._player.paused
        shots = tuple(self._player.shots)[::EACH]
        if self._plots and shots:
            time = np.array([shot.time for shot in shots])
            for title, plot in self._plots.items():
                plot.data = (time, *_series(shots, *PLOTS[title]))
        if self._handle is not None and self._player.is_running and shots:
            state = self._player.shots[-1].state
            self._handle.position = state.wrist_position
            self._handle.wxyz = wxyz(state.wrist_orientation)


def _series(shots: tuple[Shot, ...], name: str, scale: float) -> Array:
    """A quantity of each channel (channels, k) over time, in units of `scale`."""
    return np.array([getattr(shot, name) for shot in shots]).T / scale
