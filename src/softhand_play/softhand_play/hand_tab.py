"""The tab `Hand`: sliders of the channels, plots of the last seconds, wrist, pause, pace."""

from __future__ import annotations

import numpy as np
import viser
from numpy.typing import NDArray
from viser import uplot

from softhand_model.hand.hand import HandDescription
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
HANDLE = 0.1  # size [m]
COLORS = ("#1f77b4", "#ff7f0e", "#2ca02c", "#d62728", "#9467bd", "#8c564b", "#e377c2", "#7f7f7f")


class HandTab:
    """Acts on the player of a page."""

    def __init__(self, page: Board, tab: viser.GuiTabHandle) -> None:
        self._page, self._player, gui = page, page.player, page.server.gui
        self._tab = tab
        self.sliders: list[viser.GuiSliderHandle] = []
        self._tops: dict[str, float] = {}  # largest value of each channel's slider
        self._plots: dict[str, viser.GuiUplotHandle] = {}
        self._folder: viser.GuiFolderHandle | None = None
        self.handle: viser.TransformControlsHandle | None = None
        self._followed = False
        self._shown = PRESSURE  # what the sliders command
        with tab:
            self._quantity = gui.add_dropdown("command", (PRESSURE, AIR_MASS))
            self._pause = gui.add_checkbox("pause", False)
            self._pace = gui.add_dropdown("pace", tuple(PACES), visible=page.player.keeps_pace)
            self._reset = gui.add_button("reset")
        self._pause.on_update(lambda _: setattr(self._player, "paused", self._pause.value))
        self._pace.on_update(self._set_pace)
        self._reset.on_click(lambda _: self._player.reset())

    def _set_pace(self, _: viser.GuiEvent) -> None:
        self._player.pace.speed = PACES[self._pace.value]
        self._player.pace.anchor(self._player.now.shots[-1].time)

    # ---------------------------------------------------------------- a new world
    def stage(self) -> None:
        """Sliders and plots for the channels of the hand."""
        hand = self._player.now.stage.layout.description
        limits, self._shown = hand.max_pressures(), self._quantity.value
        if self._shown == AIR_MASS:
            from pneuflex_sim.pictures.hand_picture import air_masses_at  # matplotlib takes 1 s

            limits = air_masses_at(hand, limits)
        tops = dict(zip(hand.channels, limits / SCALE[self._shown], strict=True))
        if tops != self._tops:
            self._tops = tops
            self._fill(hand)
        self._followed = True
        self._place_handle()

    def _fill(self, hand: HandDescription) -> None:
        """Make sliders and plots anew."""
        if self._folder is not None:
            self._folder.remove()
        with self._tab:
            self._folder = self._page.server.gui.add_folder("channels")
        with self._folder:
            self.sliders = [self._slider(hand, name) for name in self._tops]
            self._plots = {title: self._plot(title, tuple(self._tops)) for title in PLOTS}

    def _slider(self, hand: HandDescription, name: str) -> viser.GuiSliderHandle:
        top, channel = float(f"{self._tops[name]:.3g}"), hand.channels.index(name)
        fingers = [each for each in hand.actuator_names if hand.channel_of(each) == channel]
        slider = self._page.server.gui.add_slider(
            f"channel {name}",
            0.0,
            top,
            top / STEPS,
            0.0,
            hint=f"{', '.join(fingers)}: 0 to {top:g}, {self._shown}",
        )
        slider.on_update(lambda event: self._command(channel, event))
        return slider

    def _command(self, channel: int, event: viser.GuiEvent) -> None:
        if event.client is None:  # the slider follows
            return
        wanted = np.full(len(self.sliders), np.nan)
        wanted[channel] = self.sliders[channel].value * SCALE[self._shown]
        if self._shown == PRESSURE:
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
            legend=uplot.Legend(show=title == PRESSURE),  # one is enough
            height=PLOT_HEIGHT,
        )

    def _place_handle(self) -> None:
        """The handle at the wrist; none where the wrist is fixed."""
        if self.handle is not None:
            self.handle.remove()
            self.handle = None
        now = self._player.now
        if now.stage.scene.rigid_wrist:
            return
        wrist = now.shots[-1].state
        self.handle = self._page.server.scene.add_transform_controls(
            "/wrist_handle",
            scale=HANDLE,
            depth_test=False,
            position=wrist.wrist_position,
            wxyz=wxyz(wrist.wrist_orientation),
        )
        self.handle.on_update(self._move)

    def _move(self, event: viser.TransformControlsEvent) -> None:
        place, turn = event.target.position, np.roll(event.target.wxyz, -1)
        self._player.command_wrist(np.array(place), np.array(turn))

    # ---------------------------------------------------------------- while it runs
    def refresh(self) -> None:
        """The plots of the last seconds; sliders and handle follow a strategy to its end."""
        if self._quantity.value != self._shown:
            self.stage()
        self._pause.value = self._player.paused
        shots = tuple(self._player.now.shots)
        time = np.array([shot.time for shot in shots[::EACH]])
        for title, plot in self._plots.items():
            plot.data = (time, *_series(shots[::EACH], *PLOTS[title]))
        if self._player.is_running or self._followed:
            self._follow(shots[-1])
        self._followed = self._player.is_running

    def _follow(self, shot: Shot) -> None:
        values = _series((shot,), *PLOTS[self._shown])[:, 0]
        for slider, value in zip(self.sliders, values.tolist(), strict=True):
            slider.value = slider.step * round(value / slider.step)
        if self.handle is not None:
            self.handle.position = shot.state.wrist_position
            self.handle.wxyz = wxyz(shot.state.wrist_orientation)


def _series(shots: tuple[Shot, ...], name: str, scale: float) -> Array:
    """A quantity of each channel (channels, k) over time, in units of `scale`."""
    return np.array([getattr(shot, name) for shot in shots]).T / scale
