"""Air that follows its command at the pace of the Pneumaticbox, without valves, sensors or driver.

It stands in for the driver in batch trials: the chokes limit the rate, and the smallest pulse is
the grain of what can be commanded.
"""

from __future__ import annotations

import numpy as np

from grasp_strategies.scene import Array
from softhand_model.gas import line_conductance, orifice_conductance, series_flow
from softhand_model.pneumatics.parameters import Pneumatics, load_pneumatics

SMALLEST_PULSE = 2.5e-6  # air that one shortest opening of a valve moves (thesis 4.3) [kg]


class ImposedAir:
    """Air masses (channels,) [kg above the fill at rest] on their way to the commanded ones.

    A command is met to the nearest whole pulse. Until then a channel fills from the supply or
    empties to ambient through its choke and tube (mean of their tolerances).

    >>> air = ImposedAir(1)
    >>> air.command(np.array([1.1e-5]))
    >>> for _ in range(1000):
    ...     masses = air.advance(0.001, np.array([120e3]))
    >>> round(1e6 * float(masses[0]), 3)
    10.0
    """

    def __init__(self, channels: int, parameters: Pneumatics | None = None) -> None:
        box = parameters or load_pneumatics()
        foil = float(np.mean(box.choke.discharge_coefficient)) * np.pi / 4
        self._inlet = orifice_conductance(foil * box.choke.inlet_diameter**2, box.temperature)
        self._outlet = orifice_conductance(foil * box.choke.outlet_diameter**2, box.temperature)
        self._line = line_conductance(
            box.line.diameter, float(np.mean(box.line.length)), box.temperature
        )
        self._ambient = box.ambient_pressure
        self._supply = box.supply.pressure + box.ambient_pressure
        self.masses: Array = np.zeros(channels)
        self._goal: Array = np.zeros(channels)

    def command(self, masses: Array) -> None:
        """Set the masses to reach [kg]; raises ValueError unless there is one number a channel."""
        wanted = np.asarray(masses, float)
        if wanted.shape != self.masses.shape or not np.isfinite(wanted).all():
            raise ValueError(
                f"air masses: expected {len(self.masses)} finite numbers, got {masses}"
            )
        self._goal = np.round(wanted / SMALLEST_PULSE) * SMALLEST_PULSE

    def advance(self, duration: float, pressures_abs: Array) -> Array:
        """Masses [kg] after `duration` [s] with the channels at absolute pressures [Pa]."""
        missing = self._goal - self.masses
        if missing.any():
            self.masses = self.masses + np.clip(
                missing,
                -duration * series_flow(pressures_abs, self._ambient, self._outlet, self._line),
                duration * series_flow(self._supply, pressures_abs, self._inlet, self._line),
            )
        return self.masses
