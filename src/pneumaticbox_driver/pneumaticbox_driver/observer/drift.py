"""Drift of the estimated air mass: its uncertainty, and its correction by pressure and volume.

The estimate of equation 4.1 drifts with every pulse (section 4.4.4). With closed valves, constant
pressures and the hand in free posture, the mass also follows from pressure and volume:
`m = (p_abs V(p) - p_0 V_0)/(R_s T)`.
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from pneumaticbox_driver.arrays import Flags, Floats
from pneumaticbox_driver.observer.coefficients import VALVE_DIRECTIONS, ChannelCalibration
from pneumaticbox_driver.observer.volume_model import VolumeModel
from pneumaticbox_driver.settings import BoxSettings
from softhand_model.gas import GAS_CONSTANT

# of a zeroed sensor, one sigma: remaining offset [Pa] and relative error of its gain [-]
OFFSET_ERROR = 15.0
GAIN_ERROR = 0.003
GROWTH_ERROR = 0.01  # relative error of the model's growth of a volume, one sigma [-]
GATE = 5.0  # standard deviations; larger errors mean a hand in contact or a wrong calibration
BOUND_SIGMAS = 2.0


class PostureMass:
    """Air masses from pressures while the hand is in free posture; arrays (n,).

    Args:
        settings: settings of the box.
        model: model of the channels' volumes.
    """

    def __init__(self, settings: BoxSettings, model: VolumeModel) -> None:
        self._model = model
        self._ambient = settings.ambient
        self._gas = GAS_CONSTANT * settings.temperature
        self._rest = np.array(settings.rest_volumes)

    def at(self, pressures_abs: Floats) -> tuple[Floats, Floats]:
        """Masses above the fill at rest [kg] and their variances [kg2], (n,) and (n,).

        Args:
            pressures_abs: absolute, averaged, without the sensors' offsets (n,) [Pa].
        """
        pressures = pressures_abs - self._ambient
        volumes = self._model.volumes(pressures)
        mass = (pressures_abs * volumes - self._ambient * self._rest) / self._gas
        by_pressure = (volumes + pressures_abs * self._model.slopes(pressures)) / self._gas
        sensor = by_pressure * np.hypot(OFFSET_ERROR, GAIN_ERROR * pressures)
        model = GROWTH_ERROR * (volumes - self._rest) * pressures_abs / self._gas
        return np.asarray(mass), np.asarray(sensor**2 + model**2)

    def bent_at(self, pressures: Floats) -> tuple[Floats, Floats]:
        """Air masses above rest at gauge pressures, and at ambient pressure in the same posture.

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
    """Combine estimated masses with measured ones (Kalman gain).

    A measurement with a larger variance than the estimate is not used: its errors are systematic
    ones of the sensor and the model, which repetition does not reduce. A measurement further from
    the estimate than both uncertainties explain is not used, either: the hand is not in free
    posture, or the calibration does not fit.

    Args:
        mass: estimated masses (n,) [kg].
        variance: variance of the estimates (n,) [kg2].
        measured: masses from pressure and volume (n,) [kg].
        noise: variances of the measured masses (n,) [kg2].

    Returns:
        Masses (n,) [kg], variances (n,) [kg2], flags of the used measurements (n,) and of those too
        far from the estimate (n,).

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

    The estimate is linear in the coefficients, so that their errors contribute `X^T C X` for each
    direction, with `X` the sum of the regressors of equation 4.1 and `C` the covariance of the
    regression. The scatter of the valve's delays, independent for each pulse, contributes the
    square of jitter times flow. Gain errors of the sensors are not included, as they affect the
    calibration, too.

    Args:
        calibrations: calibrations of the channels.
    """

    def __init__(self, calibrations: Sequence[ChannelCalibration]) -> None:
        n = len(calibrations)
        self.pulses: NDArray[np.int_] = np.zeros(n, dtype=int)  # since the mass was known
        self._sums: Floats = np.zeros((2, 5, n))
        self._variance: Floats = np.zeros(n)  # of all other errors [kg2]
        self._bound: Floats | None = None  # until the next change
        self._take(calibrations)

    def _take(self, calibrations: Sequence[ChannelCalibration]) -> None:
        fits = [[getattr(c, direction) for c in calibrations] for direction in VALVE_DIRECTIONS]
        self._covariance = np.array([[fit.covariance for fit in row] for row in fits])
        self._jitter = np.array([[fit.jitter for fit in row] for row in fits])

    def set_calibrations(self, calibrations: Sequence[ChannelCalibration]) -> None:
        """Use other coefficients for the next pulses; the variance so far is kept."""
        self._variance, self._bound = self.variance(), None
        self._sums[:] = 0.0
        self._take(calibrations)

    def restart(self, channel: int) -> None:
        """Clear the variance of a channel whose mass is known now."""
        self.pulses[channel] = 0
        self._sums[:, :, channel] = 0.0
        self._variance[channel], self._bound = 0.0, None

    def add(self, channels: Flags, inflating: Flags, regressors: Floats, mean_flow: Floats) -> None:
        """Add a pulse on each of the `channels` (n,).

        Args:
            channels: marks the channels that had a pulse (n,).
            inflating: marks the channels whose pulse inflated (n,).
            regressors: regressors of equation 4.1 (5, n).
            mean_flow: mean flow during the pulse (n,) [kg/s].
        """
        for row, here in enumerate((channels & inflating, channels & ~inflating)):
            self._sums[row] += regressors * here
            self._variance += here * (self._jitter[row] * mean_flow) ** 2
        self.pulses += channels
        self._bound = None

    def variance(self) -> Floats:
        """Variance of the estimates (n,) [kg2]."""
        by_coefficients = np.einsum("dkn,dnkl,dln->n", self._sums, self._covariance, self._sums)
        return self._variance + np.maximum(by_coefficients, 0.0)

    @property
    def bound(self) -> Floats:
        """Two standard deviations of the estimates (n,) [kg], not to be changed."""
        if self._bound is None:
            self._bound = BOUND_SIGMAS * np.sqrt(self.variance())
        return self._bound
