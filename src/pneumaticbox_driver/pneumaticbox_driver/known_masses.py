"""Where air masses are known: at the start, at ambient pressure, and when the user tares."""

import numpy as np
from numpy.typing import NDArray

from pneumaticbox_driver.observer import MassObserver
from pneumaticbox_driver.settings import BoxSettings
from pneumaticbox_driver.zeroing import StillPressure
from softhand_model.gas import air_mass

Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]
Valves = NDArray[np.int8]
UNEXPLAINED_PRESSURE = 5e3  # in an emptied channel: it was held away from rest when zeroed [Pa]
LONGEST_START = 1.0  # after which the box no longer waits for pressures to stand still [s]


class KnownMasses:
    """Sets the estimated masses and the offsets of the sensors where they are known; arrays (n,).

    `ready` says that the sensors have been averaged, `empty` marks channels known to be at ambient
    pressure since their outlet was last open, `offsets` [Pa] are those of the channel sensors.

    Args:
        settings: of the box.
        observer: whose estimates are set.
        notes: takes sentences for the user.
    """

    def __init__(self, settings: BoxSettings, observer: MassObserver, notes: list[str]) -> None:
        n = len(settings.channels)
        self.offsets: Floats = np.zeros(n)
        self._settings = settings
        self._observer = observer
        self._notes = notes
        self._still = StillPressure(n)
        self.restart()

    def restart(self) -> None:
        """Begin anew: the sensors are averaged first."""
        self.ready = False
        self.empty: Flags = np.zeros(len(self.offsets), dtype=bool)
        self._still.restart()
        self._waited = 0.0

    @property
    def still(self) -> bool:
        """Whether the pressures of all channels stand still."""
        return bool(self._still.still.all())

    def steady(self, pressures: Floats) -> Floats:
        """Pressures (n,) [Pa], averaged over 0.1 s where the valve has rested as long."""
        return np.where(np.isnan(self._still.mean), pressures, self._still.mean)

    def switched(self, changed: Flags, valves: Valves) -> None:
        """Take note of the valves (n,) that have `changed` with this sample."""
        self.empty &= valves <= 0
        self._still.restart(changed)

    def look(self, dt: float, pressures: Floats, valves: Valves) -> None:
        """Zero what stands still at ambient pressure: at the start, and with outlets open.

        Args:
            dt: since the last sample [s].
            pressures: absolute, offsets taken off (n,) [Pa]; a found offset is taken off in place.
            valves: commanded until now (n,).
        """
        self._waited += dt
        self.empty &= pressures - self._settings.ambient < UNEXPLAINED_PRESSURE
        if not self._still.add(dt, pressures):
            return
        if self.ready:
            at_ambient = self._still.still & self._within_zero_band()
            for channel in np.flatnonzero((valves < 0) & at_ambient & ~self.empty).tolist():
                self._zero(channel, pressures)
        elif self._still.still.all() or self._waited > LONGEST_START:
            self.tare(pressures)
            self.ready = True

    def tare(self, pressures: Floats) -> list[str]:
        """Set all masses from the averaged pressures; returns the channels not at ambient.

        `pressures` (n,) [Pa] are absolute; a found offset is taken off in place.
        """
        settings = self._settings
        at_ambient = self._within_zero_band()
        under_pressure = []
        for channel, name in enumerate(settings.channels):
            if at_ambient[channel]:
                self._zero(channel, pressures)
                continue
            gauge = float(self._still.mean[channel]) - settings.ambient
            mass = float(air_mass(gauge, settings.rest_volumes[channel], settings.temperature))
            self._observer.set_mass(channel, mass)
            under_pressure.append(name)
        self._still.restart()
        if under_pressure:
            self._notes.append(f"tared under pressure by the rest volume: {under_pressure}")
        return under_pressure

    def _within_zero_band(self) -> Flags:
        reading = self._still.mean + self.offsets - self._settings.ambient
        return np.abs(reading) < self._settings.zero_band

    def _zero(self, channel: int, pressures: Floats) -> None:
        """Take the channel's averaged pressure as ambient, its mass as that at rest."""
        error = float(self._still.mean[channel]) - self._settings.ambient
        self.offsets[channel] += error
        pressures[channel] -= error
        self._observer.set_mass(channel, 0.0)
        self.empty[channel] = True
