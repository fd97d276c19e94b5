"""Interface of the controllers: their input from the box and their output."""

from dataclasses import dataclass, field
from typing import Protocol

import numpy as np

from pneumaticbox_driver.arrays import Flags, Floats, Valves
from pneumaticbox_driver.observer.observer import MassObserver
from pneumaticbox_driver.observer.volume_model import VolumeModel

OPENING_SHARE = 0.55  # of the smallest pulse; above one half, so that a pulse reduces the error
LEAST_ERROR = 1e-7  # smaller errors open no valve [kg]


@dataclass
class BoxView:
    """State of all channels at one sensor sample; arrays (n,), SI units.

    `direction` are the presently commanded valves, `empty` marks channels known to be at ambient
    pressure since their outlet was last open, `shortest_pulse` [s] is that of the valves, `dt` [s]
    the time since the last sample, `mine` marks the channels of the called controller. `setpoints`
    are NaN where there is none and for channels of other controllers. `gas` is the product of gas
    constant and temperature [J/kg], `limits` are gauge pressures [Pa].
    """

    observer: MassObserver
    volume_model: VolumeModel
    rest_volumes: Floats
    limits: Floats
    ambient: float
    gas: float
    shortest_pulse: float
    pressures_abs: Floats = field(init=False)
    setpoints: Floats = field(init=False)
    direction: Valves = field(init=False)
    empty: Flags = field(init=False)
    mine: Flags = field(init=False)
    supply_abs: float = field(init=False)
    dt: float = field(init=False)

    def volume_at(self, pressures_abs: Floats) -> Floats:
        """Volumes (n,) [m3], `m R_s T/p_abs` of the estimated mass at absolute pressures [Pa]."""
        content = self.observer.mass * self.gas + self.ambient * self.rest_volumes
        return np.asarray(content / pressures_abs)


class Controller(Protocol):
    """Computes valves of all channels, of which those in the controller's mode are used."""

    def update(self, view: BoxView) -> Valves:
        """Return the wanted valves (n,): +1 inflate, -1 deflate, 0 closed."""
        ...
