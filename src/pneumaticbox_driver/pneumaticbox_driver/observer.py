"""The observer of contained air mass: sums up the pulses of equation 4.1 (section 4.4.1)."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from pneumaticbox_driver.calibration import ChannelCalibration
from pneumaticbox_driver.flow_model import flow_rates
from pneumaticbox_driver.pulse_integrals import PulseIntegrals
from softhand_model.gas import AMBIENT_PRESSURE

Floats = NDArray[np.float64]
Valves = NDArray[np.int8]


class MassObserver:
    """Estimates the air mass of each channel from pressures and the commanded valves.

    Equation 4.1 gives the mass that a pulse will have moved if its valve were switched off now;
    what still flows during the closing delay and out of the dead volume is in its coefficients.
    So `mass` runs ahead of the true mass by what the valve's delay makes inevitable, which is
    what a controller needs to close in time. All arrays have the channels in order (n,).

    Args:
        calibrations: coefficients of the channels, one each.
        ambient: absolute ambient pressure [Pa].
    """

    def __init__(
        self, calibrations: Sequence[ChannelCalibration], ambient: float = AMBIENT_PRESSURE
    ) -> None:
        n = len(calibrations)
        self._inflate = np.array([c.inflate.as_array() for c in calibrations]).T
        self._deflate = np.array([c.deflate.as_array() for c in calibrations]).T
        self._integrals = PulseIntegrals(n, ambient)
        self._coefficients: Floats = np.zeros((5, n))  # of the pulses under way
        self._settled: Floats = np.zeros(n)
        self._moved: Floats = np.zeros(n)
        self.direction: Valves = np.zeros(n, dtype=np.int8)
        self.flow: Floats = np.zeros(n)  # into the channels [kg/s]

    @property
    def mass(self) -> Floats:
        """Mass above the fill at rest once all valves, switched off now, have closed (n,) [kg]."""
        return self._settled + self._moved

    def advance(self, dt: float, pressures: Floats, supply: float) -> None:
        """Integrate the pulses under way over the last `dt` [s], up to these absolute pressures.

        Args:
            dt: time since the last sample [s], 0 or above.
            pressures: absolute channel pressures (n,) [Pa].
            supply: absolute supply pressure [Pa].
        """
        if not self.direction.any():
            return
        integrals, c = self._integrals, self._coefficients
        integrals.advance(dt, pressures, supply)
        moved = (c * integrals.values).sum(axis=0)
        friction, injector = integrals.rates
        self._moved = self.direction * np.maximum(moved, 0.0)
        self.flow = self.direction * (c[1] * friction + c[2] * injector)

    def switch(self, valves: Valves, pressures: Floats, supply: float) -> None:
        """Take note of the valves commanded from now on; call after `advance` of this sample.

        Args:
            valves: +1 inflate, -1 deflate, 0 closed (n,).
            pressures: absolute channel pressures (n,) [Pa].
            supply: absolute supply pressure [Pa].
        """
        changed = valves != self.direction
        if not changed.any():
            return
        self._settled = np.where(changed, self._settled + self._moved, self._settled)
        self._moved = np.where(changed, 0.0, self._moved)
        self.flow = np.where(changed, 0.0, self.flow)
        self.direction = valves.copy()
        begun = np.where(valves > 0, self._inflate, self._deflate) * (valves != 0)
        self._coefficients = np.where(changed, begun, self._coefficients)
        self._integrals.begin(changed, valves, pressures, supply)

    def pulse_mass(
        self, duration: float, pressures: Floats, supply: float
    ) -> tuple[Floats, Floats]:
        """Predict what a pulse of `duration` [s] from these pressures would move.

        The pressures are taken as constant over the pulse.

        Returns:
            Mass that an inflating pulse brings and that a deflating one takes (n,), (n,) [kg],
            both 0 or above.
        """
        inlet = np.full_like(pressures, supply)
        ambient = np.full_like(pressures, self._integrals.ambient)
        gain = _pulse(self._inflate, duration, inlet, pressures)
        return gain, _pulse(self._deflate, duration, pressures, ambient)

    def set_mass(self, channel: int, mass: float) -> None:
        """Correct the estimate of a channel to `mass` [kg].

        A pulse under way is taken to move nothing more: this is for a channel that stands still,
        and with noise on its pressure equation 4.1 would go on to see a small flow.
        """
        self._settled[channel] = mass
        self._moved[channel] = 0.0
        self._coefficients[:, channel] = 0.0


def _pulse(coefficients: Floats, duration: float, upstream: Floats, downstream: Floats) -> Floats:
    friction, injector = flow_rates(upstream, downstream)
    return np.maximum(
        coefficients[0]
        + duration * (coefficients[1] * friction + coefficients[2] * injector)
        + coefficients[3] * upstream
        + coefficients[4] * downstream,
        0.0,
    )
