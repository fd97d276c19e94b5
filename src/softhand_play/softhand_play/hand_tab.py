"""The tab `Hand`: sliders of the channels, plots over time, wrist handle, pause, pace."""

from __future__ import annotations

import numpy as np
import viser
from viser import uplot

from softhand_common.numerics.arrays import Array
from softhand_model.hand.hand import HandDescription
from softhand_play.frames import Frame
from softhand_play.page_context import PageContext
from softhand_play.view import wxyz

PRESSURE_LABEL, AIR_MASS_LABEL = "pressure [kPa]", "air mass [mg]"
SLIDER_UNITS = {PRESSURE_LABEL: 1e3, AIR_MASS_LABEL: 1e-6}  # in Pa and kg
PLOTS = {
    PRESSURE_LABEL: ("pressures", 1e3),
    AIR_MASS_LABEL: ("masses", 1e-6),
    "volume [ml]": ("volumes", 1e-6),
}
PLOT_HEIGHT = 130  # [pixels]
PACES = {"real time": 1.0, "1/2": 0.5, "1/5": 0.2, "1/10": 0.1}
PLOT_STRIDE = 4  # the plots show every fourth frame
SLIDER_STEPS = 200
HANDLE_SIZE = 0.1  # [m]
CHANNEL_COLORS = (
    "#1f77b4",
    "#ff7f0e",
    "#2ca02c",
    "#d62728",
    "#9467bd",
    "#8c564b",
    "#e377c2",
    "#7f7f7f",
)


class HandTab:
    """The tab whose controls command the hand that the page's player simulates."""

    def __init__(self, page: PageContext, tab: viser.GuiTabHandle) -> None:
        self._page, self._player, gui = page, page.player, page.server.gui
        self._tab = tab
        self.sliders: list[viser.GuiSliderHandle] = []
        self._tops: dict[str, float] = {}  # largest value of the slider of each channel
        self._plots: dict[str, viser.GuiUplotHandle] = {}
        self._folder: viser.GuiFolderHandle | None = None
        self.handle: viser.TransformControlsHandle | None = None
        self._followed = False
        self._shown = PRESSURE_LABEL  # the commanded quantity
        with tab:
            self._quantity = gui.add_dropdown("command", (PRESSURE_LABEL, AIR_MASS_LABEL))
            self._pause = gui.add_checkbox("pause", False)
            self._pace = gui.add_dropdown("pace", tuple(PACES), visible=page.player.keeps_pace)
            self._reset = gui.add_button("reset")
            if page.live:
                gui.add_button("vent the box").on_click(lambda _: self._player.vent_box())
                gui.add_button("reset the box").on_click(lambda _: self._player.reset_box())
        self._pause.on_update(lambda _: setattr(self._player, "paused", self._pause.value))
        self._pace.on_update(self._set_pace)
        self._reset.on_click(lambda _: self._player.reset())

    def _set_pace(self, _: viser.GuiEvent) -> None:
        self._player.pace.speed = PACES[self._pace.value]
        self._player.pace.anchor(self._player.now.frames[-1].time)

    # ---------------------------------------------------------------- a new world
    def show_world(self) -> None:
        """Show sliders, plots and the wrist handle of the current hand."""
        hand = self._player.now.static_scene.layout.description
        limits, quantity = hand.max_pressures(), self._quantity.value
        if quantity == AIR_MASS_LABEL:
            from pneuflex_sim.pictures.hand_picture import air_masses_at  # matplotlib takes 1 s

            limits = air_masses_at(hand, limits)
        tops = dict(zip(hand.channels, limits / SLIDER_UNITS[quantity], strict=True))
        if (tops, quantity) != (self._tops, self._shown):
            self._tops = tops
            self._fill(hand, quantity)
        self._shown = quantity  # now that the sliders are those of it
        self._followed = True
        self._place_handle()

    def _fill(self, hand: HandDescription, quantity: str) -> None:
        """Replace sliders and plots."""
        if self._folder is not None:
            self._folder.remove()
        with self._tab:
            self._folder = self._page.server.gui.add_folder("channels")
        with self._folder:
            self.sliders = [self._slider(hand, name, quantity) for name in self._tops]
            self._plots = {title: self._plot(title, tuple(self._tops)) for title in PLOTS}

    def _slider(self, hand: HandDescription, name: str, quantity: str) -> viser.GuiSliderHandle:
        top, channel = float(f"{self._tops[name]:.3g}"), hand.channels.index(name)
        filled = [each for each in hand.actuator_names if hand.channel_of(each) == channel]
        parts = ", ".join(filled).replace("_", " ")
        slider = self._page.server.gui.add_slider(
            f"{name}: {parts}",
            0.0,
            top,
            top / SLIDER_STEPS,
            0.0,
            hint=f"channel {name} fills {parts}: 0 to {top:g}, {quantity}",
        )
        others = np.full(len(hand.channels), np.nan)
        slider.on_update(lambda event: self._command(quantity, channel, others, event))
        return slider

    def _command(self, quantity: str, channel: int, others: Array, event: viser.GuiEvent) -> None:
        """Command what a slider was made for, which may not be what is shown by now."""
        if event.client is None:  # the slider follows
            return
        wanted = others.copy()
        wanted[channel] = event.target.value * SLIDER_UNITS[quantity]
        if quantity == PRESSURE_LABEL:
            self._player.command_pressures(wanted)
        else:
            self._player.command_masses(wanted)

    def _plot(self, title: str, channels: tuple[str, ...]) -> viser.GuiUplotHandle:
        series = [
            uplot.Series(label=name, stroke=CHANNEL_COLORS[k % len(CHANNEL_COLORS)], width=2)
            for k, name in enumerate(channels)
        ]
        empty = tuple(np.zeros(1) for _ in range(len(channels) + 1))
        return self._page.server.gui.add_uplot(
            empty,
            (uplot.Series(label="time [s]"), *series),
            title=title,
            scales={"x": uplot.Scale(time=False)},
            legend=uplot.Legend(show=title == PRESSURE_LABEL),  # in the first plot only
            height=PLOT_HEIGHT,
        )

    def _place_handle(self) -> None:
        """Put a handle at the wrist unless the wrist is fixed."""
        if self.handle is not None:
            self.handle.remove()
            self.handle = None
        now = self._player.now
        if now.static_scene.scene.rigid_wrist:
            return
        wrist = now.frames[-1].state
        self.handle = self._page.server.scene.add_transform_controls(
            "/wrist_handle",
            scale=HANDLE_SIZE,
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
        """Update the plots; while a strategy runs, sliders and handle follow it."""
        if self._quantity.value != self._shown:
            self.show_world()
        self._pause.value = self._player.paused
        frames = tuple(self._player.now.frames)
        time = np.array([frame.time for frame in frames[::PLOT_STRIDE]])
        for title, plot in self._plots.items():
            plot.data = (time, *_series(frames[::PLOT_STRIDE], *PLOTS[title]))
        if self._player.is_running or self._followed:
            self._follow(frames[-1])
        self._followed = self._player.is_running

    def _follow(self, frame: Frame) -> None:
        values = np.maximum(_series((frame,), *PLOTS[self._shown])[:, 0], 0.0)
        for slider, value in zip(self.sliders, values.tolist(), strict=True):
            slider.value = slider.step * round(value / slider.step)
        if self.handle is not None:
            self.handle.position = frame.state.wrist_position
            self.handle.wxyz = wxyz(frame.state.wrist_orientation)


def _series(frames: tuple[Frame, ...], name: str, scale: float) -> Array:
    """A quantity of each channel over time (channels, k), in units of `scale`."""
    return np.array([getattr(frame, name) for frame in frames]).T / scale
