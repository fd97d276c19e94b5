"""The controllers of all channels, each channel in its own mode."""

from collections.abc import Sequence

import numpy as np

from pneumaticbox_driver.controllers.available import make_controller
from pneumaticbox_driver.controllers.mass import rehearse_mass_control
from pneumaticbox_driver.controllers.view import BoxView, Controller, Flags, Valves


class ControllerBank:
    """One controller per mode in use; each sees all channels and decides on those in its mode.

    Args:
        modes: of the channels (n,).

    Raises:
        ValueError: a mode that is not available.
    """

    def __init__(self, modes: Sequence[str]) -> None:
        self.modes: tuple[str, ...] = ()
        self._controllers: dict[str, Controller] = {}
        self._masks: dict[str, Flags] = {}
        self._closed: Valves = np.zeros(len(modes), dtype=np.int8)
        self.switch(modes)
        rehearse_mass_control(len(modes))

    def switch(self, modes: Sequence[str]) -> None:
        """Put the channels into these modes (n,); raises ValueError and changes nothing then."""
        before = self._controllers
        controllers = {mode: before.get(mode) or make_controller(mode) for mode in modes}
        self.modes, self._controllers = tuple(modes), controllers
        self._masks = {mode: np.array([m == mode for m in modes]) for mode in controllers}

    def update(self, view: BoxView) -> Valves:
        """Return the wanted valves (n,): +1 inflate, -1 deflate, 0 closed."""
        wanted = self._closed
        for mode, controller in self._controllers.items():
            view.mine = self._masks[mode]
            wanted = np.where(view.mine, controller.update(view), wanted)
        return wanted
