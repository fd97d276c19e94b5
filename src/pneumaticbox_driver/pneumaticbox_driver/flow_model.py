"""Equation 4.1: the mass that one valve pulse moves, linear in what can be measured."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from softhand_model.gas import psi

Floats = NDArray[np.float64]
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


def flow_rates(pressure_in: Floats, pressure_out: Floats) -> tuple[Floats, Floats]:
    """Integrands of the friction and the injector term of equation 4.1.

    Both change sign with the drop of pressure, for air flows back then. So the noise of a sensor
    cancels where an open outlet has brought a channel to ambient pressure; without the sign it
    would add up to a flow that is not there.

    Args:
        pressure_in: absolute pressure upstream [Pa].
        pressure_out: absolute pressure downstream [Pa].

    Returns:
        `p_in - p_out` [Pa] and `p_in Psi(p_out/p_in)` [Pa], the latter with the higher pressure
        as `p_in` and the sign of the former.

    >>> friction, injector = flow_rates(np.array([300e3, 100e3]), np.array([100e3, 300e3]))
    >>> friction.tolist(), injector.round().tolist()
    ([200000.0, -200000.0], [145253.0, -145253.0])
    """
    drop = pressure_in - pressure_out
    high, low = np.maximum(pressure_in, pressure_out), np.minimum(pressure_in, pressure_out)
    return drop, np.copysign(high * psi(low / high), drop)
