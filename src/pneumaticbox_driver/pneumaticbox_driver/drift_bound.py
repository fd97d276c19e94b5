"""How far an estimate may have drifted: the uncertainty of the coefficients, added up."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from pneumaticbox_driver.channel_calibration import ChannelCalibration

Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]
DIRECTIONS = ("inflate", "deflate")  # rows of the arrays over directions
SIGMAS = 2.0


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
        self._covariance = np.array(
            [[c.covariance(direction) for c in calibrations] for direction in DIRECTIONS]
        )
        self._jitter = np.array(
            [[getattr(c, f"jitter_{d}") for c in calibrations] for d in DIRECTIONS]
        )

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
