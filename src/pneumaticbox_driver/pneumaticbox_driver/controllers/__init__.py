"""Controllers of the channels, one kind per control mode."""

from pneumaticbox_driver.controllers.available import (
    AVAILABLE,
    check_mode,
    make_controller,
)
from pneumaticbox_driver.controllers.bank import ControllerBank
from pneumaticbox_driver.controllers.view import BoxView, Controller

__all__ = [
    "AVAILABLE",
    "BoxView",
    "Controller",
    "ControllerBank",
    "check_mode",
    "make_controller",
]
