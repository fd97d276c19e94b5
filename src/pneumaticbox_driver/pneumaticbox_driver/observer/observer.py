"""The observer of contained air mass: sums up the pulses of equation 4.1 (section 4.4.1)."""

from collections.abc import Iterable, Sequence

import numpy as np
from numpy.typing import NDArray

from pneumaticbox_driver.arrays import Flags, Floats, Valves
from pneumaticbox_driver.observer.coefficients import ChannelCalibration
from pneumaticbox_driver.observer.drift import DriftBound
from pneumaticbox_driver.observer.pulses import PulseIntegrals, predict_pulses, sum_terms
from softhand_model.gas import AMBIENT_PRESSURE

SHORTEST = 1e-3  # length of a pulse that a mean flow is taken over [s]
# From a drop of this on a sensor tells an open outlet's flow from none, and equation 4.1 its size:
# below, its flow goes with the root of the drop, that of a tube with the drop itself [Pa].
UNSEEN_DROP = 300.0


class MassObserver:
    """Estimates the air mass of each channel from pressures and the commanded valves.

    Equation 4.1 gives the mass that a pulse will have moved if its valve were switched off now;
    what still flows during the closing delay and out of the dead volume is in its coefficients.
    So `mass` runs ahead of the true mass by what the valve's delay makes inevitable, which is
    what a controller needs to close in time. After switch-off the estimate still follows the
    pressures until the valve has closed (`PulseIntegrals`). With `leak_model`, air that leaks by
    the calibration is taken off. All arrays have the channels in order (n,).

    Args:
        calibrations: coefficients of the channels, one each.
        ambient: absolute ambient pressure [Pa].
    """

    def __init__(
        self, calibrations: Sequence[ChannelCalibration], ambient: float = AMBIENT_PRESSURE
    ) -> None:
        n = len(calibrations)
        self.leak_model = False
        self._take(calibrations)
        self._integrals = PulseIntegrals(n, ambient, UNSEEN_DROP)
        self._drift = DriftBound(calibrations)
        self._coefficients: Floats = np.zeros((5, n))  # of the pulses under way
        self._sign: Floats = np.zeros(n)  # of the pulses under way; 0: there is none
        self._settled: Floats = np.zeros(n)
        self.moved: Floats = np.zeros(n)  # by the pulse under way, negative for deflation [kg]
        self.direction: Valves = np.zeros(n, dtype=np.int8)  # commanded
        self.flow: Floats = np.zeros(n)  # into the channels [kg/s]
        self._rehearse(ambient)

    def _rehearse(self, ambient: float) -> None:
        """Let the kernels be compiled, or loaded, before a sample waits for them."""
        n = len(self.flow)
        pressures_abs, found = np.full(n, ambient), np.empty((2, n))
        pulses = PulseIntegrals(n, ambient)
        pulses.advance(SHORTEST, pressures_abs, ambient)
        terms = pulses.values, pulses.rates
        sum_terms(self._coefficients, *terms, self._sign, self.direction, found)
        self.pulse_mass(SHORTEST, pressures_abs, ambient)

    def _take(self, calibrations: Sequence[ChannelCalibration]) -> None:
        self._inflate = _columns(c.inflate.as_array() for c in calibrations)
        self._deflate = _columns(c.deflate.as_array() for c in calibrations)
        self._inflate_delays = _columns(c.inflate.delays for c in calibrations)
        self._deflate_delays = _columns(c.deflate.delays for c in calibrations)
        self._leak = np.array([c.leak.conductance for c in calibrations])  # [kg/(s Pa)]

    def set_calibrations(self, calibrations: Sequence[ChannelCalibration]) -> None:
        """Use other coefficients from the next pulses on; the estimates stay.

        Raises:
            ValueError: another number of calibrations than channels.
        """
        if len(calibrations) != len(self.direction):
            n = len(self.direction)
            raise ValueError(f"calibrations must be {n}, one a channel, got {len(calibrations)}")
        self._take(calibrations)
        self._drift.set_calibrations(calibrations)

    @property
    def mass(self) -> Floats:
        """Mass above the fill at rest once all valves, switched off now, have closed (n,) [kg]."""
        return self._settled + self.moved

    @property
    def drift_bound(self) -> Floats:
        """How far the estimates may be off since `set_mass`, two standard deviations (n,) [kg].

        Pulses count when they have ended; see `DriftBound` for what is in it.
        """
        return self._drift.bound

    @property
    def pulses(self) -> NDArray[np.int_]:
        """Pulses since `set_mass`, that under way not counted (n,)."""
        return self._drift.pulses.copy()

    def advance(self, dt: float, pressures_abs: Floats, supply_abs: float) -> None:
        """Integrate the pulses under way over the last `dt` [s], up to these absolute pressures.

        Args:
            dt: time since the last sample [s], 0 or above.
            pressures_abs: absolute channel pressures (n,) [Pa].
            supply_abs: absolute supply pressure [Pa].
        """
        integrals = self._integrals
        if self._sign.any():
            integrals.advance(dt, pressures_abs, supply_abs)
            found = np.empty((2, len(pressures_abs)))
            terms = integrals.values, integrals.rates
            sum_terms(self._coefficients, *terms, self._sign, self.direction, found)
            self.moved, self.flow = found
            self._settle((self._sign != 0) & ~integrals.flowing)
        if self.leak_model:
            pressures = pressures_abs - integrals.ambient
            self._settled = self._settled - dt * self._leak * np.maximum(pressures, 0.0)

    def switch(self, valves: Valves, pressures_abs: Floats, supply_abs: float) -> None:
        """Take note of the valves commanded from now on; call after `advance` of this sample.

        Args:
            valves: +1 inflate, -1 deflate, 0 closed (n,).
            pressures_abs: absolute channel pressures (n,) [Pa].
            supply_abs: absolute supply pressure [Pa].
        """
        changed = valves != self.direction
        if not changed.any():
            return
        self._integrals.end(changed)
        self.direction = valves.copy()
        self.flow = np.where(changed, 0.0, self.flow)
        begun = changed & (valves != 0)
        if not begun.any():
            return
        self._settle(begun & (self._sign != 0))
        self._sign = np.where(begun, valves, self._sign)
        fresh = np.where(valves > 0, self._inflate, self._deflate)
        self._coefficients = np.where(begun, fresh, self._coefficients)
        delays = np.where(valves > 0, self._inflate_delays, self._deflate_delays)
        self._integrals.begin(begun, valves, pressures_abs, supply_abs, delays)

    def _settle(self, ended: Flags) -> None:
        """Add the pulses that have ended to the settled mass."""
        if not ended.any():
            return
        values, lengths, c = self._integrals.values, self._integrals.lengths, self._coefficients
        flow = (c[1] * values[1] + c[2] * values[2]) / np.maximum(lengths, SHORTEST)
        # a pulse that moved nothing, or whose channel was set since, brings no uncertainty
        moving = ended & (self.moved != 0)
        self._drift.add(moving, self._sign > 0, values, flow)
        self._settled = np.where(ended, self._settled + self.moved, self._settled)
        self.moved = np.where(ended, 0.0, self.moved)
        self._sign = np.where(ended, 0.0, self._sign)

    def pulse_mass(
        self, duration: float, pressures_abs: Floats, supply_abs: float
    ) -> tuple[Floats, Floats]:
        """Predict what a pulse of `duration` [s] from these absolute pressures would move.

        The pressures [Pa] are taken as constant over the pulse.

        Returns:
            Mass that an inflating pulse brings and that a deflating one takes (n,), (n,) [kg],
            both 0 or above.
        """
        found = np.empty((2, len(pressures_abs)))
        ends = supply_abs, self._integrals.ambient
        coefficients = self._inflate, self._deflate
        delays = self._inflate_delays, self._deflate_delays
        predict_pulses(duration, pressures_abs, ends, coefficients, delays, found)
        gain, loss = found
        return gain, loss

    def lift(self, masses: Floats) -> None:
        """Raise the estimates by `masses` (n,) [kg]; pulses and their drift go on."""
        self._settled = self._settled + masses

    def set_mass(self, channel: int, mass: float) -> None:
        """Correct the estimate of a channel to `mass` [kg]; its drift begins anew.

        A pulse under way is taken to move nothing more: this is for a channel that stands still.
        """
        self._settled[channel] = mass
        self.moved[channel] = 0.0
        self._coefficients[:, channel] = 0.0
        self._drift.restart(channel)


def _columns(rows: Iterable[Sequence[float] | Floats]) -> Floats:
    """Rows, one a channel, as columns (k, n)."""
    return np.ascontiguousarray(np.array(list(rows)).T)
