"""Controllers by the name of their mode; `make_controller` is where others join."""

from collections.abc import Callable

from pneumaticbox_driver.controllers.mass import MassController
from pneumaticbox_driver.controllers.mass_flow import MassFlowController
from pneumaticbox_driver.controllers.pressure import Pressure
from pneumaticbox_driver.controllers.pulsewise import PulsewiseController
from pneumaticbox_driver.controllers.time import TimeController
from pneumaticbox_driver.controllers.view import Controller
from pneumaticbox_driver.controllers.volume import Volume

AVAILABLE: dict[str, Callable[[], Controller]] = {
    "mass": MassController,
    "mass_flow": MassFlowController,
    "pressure": lambda: PulsewiseController(Pressure()),
    "volume": lambda: PulsewiseController(Volume()),
    "time": TimeController,
}


def check_mode(mode: str) -> str:
    """Return `mode` if there is a controller for it.

    Raises:
        ValueError: no such mode; the message lists what there is.

    >>> check_mode("mass")
    'mass'
    """
    if mode not in AVAILABLE:
        raise ValueError(f"control_mode must be one of {list(AVAILABLE)}, got {mode!r}")
    return mode


def make_controller(mode: str) -> Controller:
    """Make the controller of a mode; raises ValueError as `check_mode` does."""
    return AVAILABLE[check_mode(mode)]()
