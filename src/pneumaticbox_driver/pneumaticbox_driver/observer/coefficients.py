"""Calibration of a channel: coefficients of equation 4.1, their uncertainty, leak and ranges."""

from dataclasses import dataclass, field

import numpy as np

from pneumaticbox_driver.arrays import Floats
from softhand_model.gas import psi

VALVE_DELAY = 0.03  # from the command to the flow: the middle of Table 4.1's 20 ms to 40 ms [s]
Delays = tuple[float, float]  # of opening and closing [s]
NOMINAL_DELAYS: Delays = (VALVE_DELAY, VALVE_DELAY)
VALVE_DIRECTIONS = ("inflate", "deflate")
EQUATION_TERMS = ("bias", "friction", "injector", "switch_in", "switch_out")  # c0 ... c4
Range = tuple[float, float]
EVERYTHING: Range = (-1e9, 1e9)


@dataclass(frozen=True)
class PulseCoefficients:
    """Coefficients of equation 4.1 for one channel and one direction, and how well they fit.

    `bias` c0 [kg], `friction` c1 [kg/(Pa s)], `injector` c2 [kg/(Pa s)], `switch_in` c3 and
    `switch_out` c4 [kg/Pa]; `covariance` (5, 5) in the order of `EQUATION_TERMS`. `residual` is the
    RMS error of the fit [kg]. `jitter` [s] is the scatter of a pulse's effective duration, one
    sigma; times the flow it is the random error of equation 4.1. `delays` [s] are those of opening
    and closing.

    ERRATUM: during deflation the downstream pressure is constant, so that its column is collinear
    with the bias; `switch_out` is 0 then (Algorithm 1 lists it).
    """

    bias: float
    friction: float
    injector: float
    switch_in: float
    switch_out: float = 0.0
    residual: float = 0.0
    jitter: float = 0.0
    delays: Delays = NOMINAL_DELAYS
    covariance: Floats = field(default_factory=lambda: np.zeros((5, 5)), compare=False)

    def as_array(self) -> Floats:
        """Return c0 ... c4 in the order of `EQUATION_TERMS` (5,)."""
        return np.array([getattr(self, term) for term in EQUATION_TERMS])


def flow_rates(pressure_in_abs: Floats, pressure_out_abs: Floats) -> tuple[Floats, Floats]:
    """Integrands of the friction and the injector term of equation 4.1.

    Both have the sign of the pressure drop, as air then flows back. The noise of a sensor thus
    averages out when an open outlet has emptied a channel; without the sign it would add up to an
    apparent flow.

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
    high = np.maximum(pressure_in_abs, pressure_out_abs)
    low = np.minimum(pressure_in_abs, pressure_out_abs)
    return drop, np.copysign(high * psi(low / high), drop)


@dataclass(frozen=True)
class Leak:
    """Conductance of a channel's leak to ambient [kg/(s Pa)] and its standard error.

    `conductance` is 0 if it is below three standard errors.
    """

    conductance: float = 0.0
    error: float = 0.0


@dataclass(frozen=True)
class ChannelCalibration:
    """Calibration of one channel, inflating and deflating, from `points` recorded pulses.

    `supply_range` and `pressure_range` [Pa gauge] are those of the pulses, `outlet` is the number
    of the box's outlet from 1, 0 if unknown.
    """

    inflate: PulseCoefficients
    deflate: PulseCoefficients
    points: int = 0
    leak: Leak = Leak()
    supply_range: Range = EVERYTHING
    pressure_range: Range = EVERYTHING
    outlet: int = 0
