"""Checks whether the estimated air masses are possible at the measured pressures."""

import numpy as np

from pneumaticbox_driver.arrays import Flags, Floats
from pneumaticbox_driver.settings import BoxSettings
from softhand_model.gas import GAS_CONSTANT

# Smallest possible volume of a channel over that at rest. The volume of a bottle is constant; the
# margin is for an inaccurate rest volume and for an unknown actuator that is compressed.
LEAST_VOLUME_SHARE = {"fixed": 0.65, "hand": 0.5}
SURELY_POSSIBLE = 1.5  # largest volume over that at rest, unless the hand allows a larger one [-]
PERSISTENCE = 1.0  # time for which an estimate must be wrong, longer than switching and cooling [s]


class EstimateCheck:
    """Marks channels whose estimate would need an impossible volume.

    The volume is `V = m R_s T/p_abs` of all the air in the channel, with a margin of four standard
    deviations of the estimate. `wrong` (n,) marks the channels.

    Args:
        settings: of the box.
        greatest: largest volumes of the channels (n,) [m3].
    """

    def __init__(self, settings: BoxSettings, greatest: Floats) -> None:
        n = len(settings.channels)
        self._settings = settings
        self._gas = GAS_CONSTANT * settings.temperature
        self._rest: Floats = np.array(settings.rest_volumes)
        self._least = LEAST_VOLUME_SHARE[settings.volume_model] * self._rest
        self._greatest = np.maximum(greatest, SURELY_POSSIBLE * self._rest)
        self._since: Floats = np.full(n, np.inf)  # time from which it has been wrong [s]
        self._mass = self._gauge = self._volume = np.zeros(n)
        self.wrong: Flags = np.zeros(n, dtype=bool)

    def look(
        self, time: float, mass: Floats, drift: Floats, pressures_abs: Floats, known: Flags
    ) -> list[str]:
        """Compare estimates and pressures.

        Args:
            time: present [s].
            mass: estimates above rest (n,) [kg].
            drift: two standard deviations of the estimates (n,) [kg].
            pressures_abs: absolute (n,) [Pa].
            known: channels with a valid estimate (n,).

        Returns:
            A sentence for each channel that is newly marked.
        """
        ambient = self._settings.ambient
        self._mass, self._gauge = mass, pressures_abs - ambient
        self._volume = (mass * self._gas + ambient * self._rest) / pressures_abs
        margin = 2 * drift * self._gas / pressures_abs
        possible = (self._volume + margin >= self._least) & (
            self._volume - margin <= self._greatest
        )
        self._since = np.where(known & ~possible, np.minimum(self._since, time), np.inf)
        wrong = time - self._since >= PERSISTENCE
        new = np.flatnonzero(wrong & ~self.wrong).tolist()
        self.wrong = wrong
        return [f"channel {self._settings.channels[i]}: {self.sentence(i)}" for i in new]

    def sentence(self, channel: int) -> str:
        """A warning for a marked channel; "" for others."""
        if not self.wrong[channel]:
            return ""
        share = self._volume[channel] / self._rest[channel]
        return (
            f"an air mass of {self._mass[channel] * 1e6:.1f} mg above rest cannot be true at "
            f"{self._gauge[channel] / 1e3:.0f} kPa: it needs {share:.2f} of the volume at rest; "
            "check rest volume, calibration, tubes and sensor, then vent and tare"
        )
