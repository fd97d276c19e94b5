"""What a controller sees of the box, and what it has to answer."""

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from pneumaticbox_driver.observer import MassObserver

Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]
Valves = NDArray[np.int8]


@dataclass
class BoxView:
    """State of all channels at one sensor sample; arrays (n,), SI, pressures absolute.

    `direction` is what the valves are commanded to now, `empty` marks channels known to be at
    ambient pressure since their outlet was last open, `shortest_pulse` [s] is what the valves
    can follow, `dt` [s] the time from sample to sample.
    """

    dt: float
    shortest_pulse: float
    pressures: Floats
    supply: float
    setpoints: Floats
    direction: Valves
    empty: Flags
    observer: MassObserver


class Controller(Protocol):
    """Decides on the valves of all channels; the box takes those in the controller's mode."""

    def update(self, view: BoxView) -> Valves:
        """Return the wanted valves (n,): +1 inflate, -1 deflate, 0 closed."""
        ...
