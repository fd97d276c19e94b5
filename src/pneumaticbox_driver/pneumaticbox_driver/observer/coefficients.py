"""Equation 4.1: the mass that one valve pulse moves, and a channel's coefficients with their
uncertainty.

What a calibration says of one channel: coefficients, their uncertainty, its leak, its ranges.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from pneumaticbox_driver.arrays import Floats
from softhand_model.gas import psi

VALVE_DELAY = 0.03  # from the command to the flow: the middle of Table 4.1's 20 ms to 40 ms [s]
Delays = tuple[float, float]  # of opening and closing [s]
NOMINAL_DELAYS: Delays = (VALVE_DELAY, VALVE_DELAY)
TERMS = ("bias", "friction", "injector", "switch_in", "switch_out")  # c0 ... c4


@dataclass(frozen=True)
class PulseCoefficients:
    """Coefficients of equation 4.1 for one channel and one direction.

    `bias` c0 [kg], `friction` c1 [kg/(Pa s)], `injector` c2 [kg/(Pa s)], `switch_in` c3 and
    `switch_out` c4 [kg/Pa].

    ERRATUM: while deflating the outlet is ambient and constant, its column is collinear with the
    bias; `switch_out` is 0 there (Algorithm 1 lists it).
    """

    bias: float
    friction: float
    injector: float
    switch_in: float
    switch_out: float = 0.0

    def as_array(self) -> Floats:
        """Return c0 ... c4 in the order of `TERMS` (5,)."""
        return np.array([getattr(self, term) for term in TERMS])


def flow_rates(pressure_in_abs: Floats, pressure_out_abs: Floats) -> tuple[Floats, Floats]:
    """Integrands of the friction and the injector term of equation 4.1.

    Both change sign with the drop of pressure, for air flows back then. So the noise of a sensor
    cancels where an open outlet has brought a channel to ambient pressure; without the sign it
    would add up to a flow that is not there.

    Args:
        pressure_in_abs: absolute pressure upstream [Pa].
        pressure_out_abs: absolute pressure downstream [Pa].

    Returns:
        `p_in - p_out` [Pa] and `p_in Psi(p_out/p_in)` [Pa], the latter with the higher pressure
        as `p_in` and the sign of the former.

    >>> friction, injector = flow_rates(np.array([300e3, 100e3]), np.array([100e3, 300e3]))
    >>> friction.tolist(), injector.round().tolist()
    ([200000.0, -200000.0], [145253.0, -145253.0])
    """
    drop = pressure_in_abs - pressure_out_abs
    high, low = (
        np.maximum(pressure_in_abs, pressure_out_abs),
        np.minimum(pressure_in_abs, pressure_out_abs),
    )
    return drop, np.copysign(high * psi(low / high), drop)


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
