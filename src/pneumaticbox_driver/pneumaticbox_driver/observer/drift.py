"""Drift of the estimated air mass: how far it may be off, and what pressure and volume tell of it.

The estimate of equation 4.1 drifts with every pulse (section 4.4.4). With valves closed, pressures
still and the hand in free posture, pressure and volume tell the mass as well, at any pressure:
`m = (p_abs V(p) - p_0 V_0)/(R_s T)`.
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from pneumaticbox_driver.arrays import Flags, Floats
from pneumaticbox_driver.observer.coefficients import DIRECTIONS, ChannelCalibration
from pneumaticbox_driver.observer.volume_model import VolumeModel
from pneumaticbox_driver.settings import BoxSettings
from softhand_model.gas import GAS_CONSTANT

# of a zeroed sensor, one sigma: what is left of its offset [Pa], and its gain [of the pressure]
OFFSET_ERROR = 15.0
GAIN_ERROR = 0.003
GROWTH_ERROR = 0.01  # of the model, one sigma, of what a volume has grown from rest [-]
GATE = 5.0  # standard deviations; beyond it the hand is not free, or the calibration does not fit
SIGMAS = 2.0


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

    def at(self, pressures_abs: Floats) -> tuple[Floats, Floats]:
        """Masses above the fill at rest [kg] and their variances [kg2], (n,) and (n,).

        Args:
            pressures_abs: absolute, averaged, offsets taken off (n,) [Pa].
        """
        pressures = pressures_abs - self._ambient
        volumes = self._model.volumes(pressures)
        mass = (pressures_abs * volumes - self._ambient * self._rest) / self._gas
        by_pressure = (volumes + pressures_abs * self._model.slopes(pressures)) / self._gas
        sensor = by_pressure * np.hypot(OFFSET_ERROR, GAIN_ERROR * pressures)
        model = GROWTH_ERROR * (volumes - self._rest) * pressures_abs / self._gas
        return np.asarray(mass), np.asarray(sensor**2 + model**2)

    def bent_at(self, pressures: Floats) -> tuple[Floats, Floats]:
        """What channels hold above rest at gauge pressures, and bent as far at ambient pressure.

        Args:
            pressures: gauge (n,) [Pa].

        Returns:
            Masses (n,) and (n,) [kg].
        """
        volumes = self._model.volumes(pressures)
        kept = self._ambient * (volumes - self._rest) / self._gas
        return kept + pressures * volumes / self._gas, kept


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


class DriftBound:
    """Variance of the summed pulses of each channel since its mass was known.

    The estimate is linear in the coefficients, so the variance that they bring is exactly
    `X^T C X`, with `X` the sum of the regressors of equation 4.1 and `C` the covariance of the
    regression, for each direction. The valve's delays add, from pulse to pulse independent, the
    square of jitter times flow. Not in it are gain errors of the sensors: the calibration has
    the same.

    Args:
        calibrations: of the channels.
    """

    def __init__(self, calibrations: Sequence[ChannelCalibration]) -> None:
        n = len(calibrations)
        self.pulses: NDArray[np.int_] = np.zeros(n, dtype=int)  # since the mass was known
        self._sums: Floats = np.zeros((2, 5, n))
        self._variance: Floats = np.zeros(n)  # of what does not add up [kg2]
        self._take(calibrations)

    def _take(self, calibrations: Sequence[ChannelCalibration]) -> None:
        fits = [[getattr(c, direction) for c in calibrations] for direction in DIRECTIONS]
        self._covariance = np.array([[fit.covariance for fit in row] for row in fits])
        self._jitter = np.array([[fit.jitter for fit in row] for row in fits])

    def set_calibrations(self, calibrations: Sequence[ChannelCalibration]) -> None:
        """Go on with other coefficients; what has added up so far stays as it is."""
        self._variance = self.variance()
        self._sums[:] = 0.0
        self._take(calibrations)

    def restart(self, channel: int) -> None:
        """The mass of this channel is known now."""
        self.pulses[channel] = 0
        self._sums[:, :, channel] = 0.0
        self._variance[channel] = 0.0

    def add(self, channels: Flags, inflating: Flags, regressors: Floats, mean_flow: Floats) -> None:
        """Add a pulse on each of the `channels` (n,).

        Args:
            channels: which had a pulse.
            inflating: its direction (n,).
            regressors: of equation 4.1 (5, n).
            mean_flow: over the pulse (n,) [kg/s].
        """
        for row, here in enumerate((channels & inflating, channels & ~inflating)):
            self._sums[row] += regressors * here
            self._variance += here * (self._jitter[row] * mean_flow) ** 2
        self.pulses += channels

    def variance(self) -> Floats:
        """Variance of the estimates (n,) [kg2]."""
        by_coefficients = np.einsum("dkn,dnkl,dln->n", self._sums, self._covariance, self._sums)
        return self._variance + np.maximum(by_coefficients, 0.0)

    @property
    def bound(self) -> Floats:
        """Two standard deviations of the estimates (n,) [kg]."""
        return SIGMAS * np.sqrt(self.variance())
