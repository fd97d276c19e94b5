"""The control modes, and the controllers of all channels, each channel in its own mode.

Controllers by the name of their mode; `make_controller` is where others join.

The controllers of all channels, each channel in its own mode.
"""

from collections.abc import Callable, Sequence

import numpy as np

from pneumaticbox_driver.control.interface import BoxView, Controller, Flags, Valves
from pneumaticbox_driver.control.mass import (
    MassController,
    MassFlowController,
    rehearse_mass_control,
)
from pneumaticbox_driver.control.pulsewise import Pressure, PulsewiseController, Volume
from pneumaticbox_driver.settings import check_mode


class TimeController:
    """Commands what the schedule says: setpoints +1 inflate, -1 deflate, 0 or none closed."""

    def update(self, view: BoxView) -> Valves:
        """Return the wanted valves (n,)."""
        return np.nan_to_num(view.setpoints).astype(np.int8)


AVAILABLE: dict[str, Callable[[], Controller]] = {
    "mass": MassController,
    "mass_flow": MassFlowController,
    "pressure": lambda: PulsewiseController(Pressure()),
    "volume": lambda: PulsewiseController(Volume()),
    "time": TimeController,
}


def make_controller(mode: str) -> Controller:
    """Make the controller of a mode; raises ValueError as `check_mode` does."""
    return AVAILABLE[check_mode(mode)]()


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
