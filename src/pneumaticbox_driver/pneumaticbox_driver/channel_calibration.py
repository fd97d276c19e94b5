"""What a calibration says of one channel: coefficients, their uncertainty, its leak, its ranges."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pneumaticbox_driver.flow_model import NOMINAL_DELAYS, Delays, PulseCoefficients

Floats = NDArray[np.float64]
Matrix = tuple[tuple[float, ...], ...]
Range = tuple[float, float]
UNKNOWN: Matrix = ((0.0,) * 5,) * 5
EVERYTHING: Range = (-1e9, 1e9)


@dataclass(frozen=True)
class Leak:
    """Conductance of a channel's leak to ambient [kg/(s Pa)] and its standard error.

    `conductance` is 0 where none was found, that is below three standard errors.
    """

    conductance: float = 0.0
    error: float = 0.0


@dataclass(frozen=True)
class ChannelCalibration:
    """Calibration of one channel, inflating and deflating.

    `residual_inflate`, `residual_deflate` are RMS [kg] over the `points` recorded pulses;
    `covariance_inflate`, `covariance_deflate` (5, 5) those of the coefficients in the order of
    `TERMS`; `jitter_inflate`, `jitter_deflate` [s] the scatter of a pulse's effective duration;
    `delays_inflate`, `delays_deflate` [s] from the commands to the opening and to the closing.
    `supply_range` and `pressure_range` [Pa gauge] are what the pulses covered, `outlet` is that
    of the box, counted from 1, 0 if unknown.
    """

    inflate: PulseCoefficients
    deflate: PulseCoefficients
    residual_inflate: float
    residual_deflate: float
    points: int
    covariance_inflate: Matrix = UNKNOWN
    covariance_deflate: Matrix = UNKNOWN
    jitter_inflate: float = 0.0
    jitter_deflate: float = 0.0
    delays_inflate: Delays = NOMINAL_DELAYS
    delays_deflate: Delays = NOMINAL_DELAYS
    leak: Leak = Leak()
    supply_range: Range = EVERYTHING
    pressure_range: Range = EVERYTHING
    outlet: int = 0

    def covariance(self, direction: str) -> Floats:
        """Covariance of the coefficients of `inflate` or `deflate` (5, 5)."""
        return np.array(getattr(self, f"covariance_{direction}"))

    def errors(self, direction: str) -> Floats:
        """Standard errors of the coefficients of `inflate` or `deflate` (5,), units of theirs."""
        return np.sqrt(np.diag(self.covariance(direction)))


def as_matrix(values: ArrayLike) -> Matrix:
    """A (5, 5) array as nested tuples, so that calibrations can be compared."""
    rows: list[list[Any]] = np.asarray(values, dtype=float).tolist()
    return tuple(tuple(row) for row in rows)
