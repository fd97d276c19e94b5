"""What pressure and volume model tell of the air mass, weighted against what the observer says.

The estimate of equation 4.1 drifts with every pulse (section 4.4.4). With valves closed, pressures
still and the hand in free posture, pressure and volume tell the mass as well, at any pressure:
`m = (p_abs V(p) - p_0 V_0)/(R_s T)`.
"""

import numpy as np
from numpy.typing import NDArray

from pneumaticbox_driver.settings import BoxSettings
from pneumaticbox_driver.volume_model import VolumeModel
from softhand_model.gas import GAS_CONSTANT

Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]
# of a zeroed sensor, one sigma: what is left of its offset [Pa], and its gain [of the pressure]
OFFSET_ERROR = 15.0
GAIN_ERROR = 0.003
GROWTH_ERROR = 0.01  # of the model, one sigma, of what a volume has grown from rest [-]
GATE = 5.0  # standard deviations; beyond it the hand is not free, or the calibration does not fit


class PostureMass:
    """Air masses that pressures tell while the hand is in free posture; arrays (n,).

    Args:
        settings: of the box.
        model: of the channels' volumes.
    """

    def __init__(self, settings: BoxSettings, model: VolumeModel) -> None:
        self._model = model
        self._ambient = settings.ambient
        self._gas = GAS_CONSTANT * settings.temperature
        self._rest = np.array(settings.rest_volumes)

    def at(self, pressures: Floats) -> tuple[Floats, Floats]:
        """Masses above the fill at rest [kg] and their variances [kg2], (n,) and (n,).

        Args:
            pressures: absolute, averaged, offsets taken off (n,) [Pa].
        """
        gauge = pressures - self._ambient
        volumes = self._model.volumes(gauge)
        mass = (pressures * volumes - self._ambient * self._rest) / self._gas
        by_pressure = (volumes + pressures * self._model.slopes(gauge)) / self._gas
        sensor = by_pressure * np.hypot(OFFSET_ERROR, GAIN_ERROR * gauge)
        model = GROWTH_ERROR * (volumes - self._rest) * pressures / self._gas
        return np.asarray(mass), np.asarray(sensor**2 + model**2)

    def bent_at(self, gauge: Floats) -> tuple[Floats, Floats]:
        """What channels hold above rest at gauge pressures, and bent as far at ambient pressure.

        Args:
            gauge: pressures (n,) [Pa].

        Returns:
            Masses (n,) and (n,) [kg].
        """
        volumes = self._model.volumes(gauge)
        kept = self._ambient * (volumes - self._rest) / self._gas
        return kept + gauge * volumes / self._gas, kept


def combine(
    mass: Floats, variance: Floats, measured: Floats, noise: Floats
) -> tuple[Floats, Floats, Flags, Flags]:
    """Weigh estimated masses against measured ones (Kalman's gain).

    A measurement worse than the estimate is left out: its errors are those of one sensor and one
    model, so that no repetition makes it better. One that is further away than both uncertainties
    allow is left out too: the posture is not the free one, or the calibration does not fit.

    Args:
        mass: estimates (n,) [kg].
        variance: of the estimates (n,) [kg2].
        measured: masses by pressure and volume (n,) [kg].
        noise: their variances (n,) [kg2].

    Returns:
        Masses (n,) [kg], variances (n,) [kg2], which measurements were used (n,) and which were
        too far away (n,).

    >>> one = np.ones(1)
    >>> mass, variance, used, far = combine(0 * one, 4 * one, 5 * one, one)
    >>> round(float(mass[0]), 6), round(float(variance[0]), 6), bool(used[0]), bool(far[0])
    (4.0, 0.8, True, False)
    """
    far = (measured - mass) ** 2 > GATE**2 * (variance + noise)
    used = (variance > noise) & ~far
    gain = np.where(used, variance / (variance + noise), 0.0)
    return mass + gain * (measured - mass), (1.0 - gain) * variance, used, far
