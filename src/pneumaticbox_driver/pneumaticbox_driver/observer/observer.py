"""The observer of the air mass in the channels: sums the masses of the pulses by equation 4.1
(section 4.4.1)."""

from collections.abc import Iterable, Sequence

import numpy as np
from numpy.typing import NDArray

from pneumaticbox_driver.arrays import Flags, Floats, Valves, same, some
from pneumaticbox_driver.observer.coefficients import ChannelCalibration
from pneumaticbox_driver.observer.drift import DriftBound
from pneumaticbox_driver.observer.pulses import PulseIntegrals, predict_pulses
from softhand_model.gas import AMBIENT_PRESSURE

SHORTEST_MEAN = 1e-3  # shortest time for a mean flow [s]
# Smallest drop at which a sensor can detect the flow of an open outlet and equation 4.1 describes
# it: below, its flow is proportional to the root of the drop, that of a tube to the drop [Pa].
UNSEEN_DROP = 300.0


class MassObserver:
    """Estimates the air mass of each channel from pressures and the commanded valves.

    Equation 4.1 gives the mass that a pulse will have moved if its valve is switched off now; the
    flow during the closing delay and out of the dead volume is part of its coefficients. `mass` is
    therefore ahead of the true mass by the air that will still flow, which a controller needs to
    close the valve in time. After switch-off the estimate follows the pressures until the valve
    has closed (`PulseIntegrals`). With `leak_model` the leak of the calibration is subtracted. All
    arrays have the channels in order (n,).

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
        self._coefficients: Floats = np.zeros((5, n))  # of the running pulses
        self._sign: Floats = np.zeros(n)  # of the running pulses; 0 for none
        self._settled: Floats = np.zeros(n)
        self.moved: Floats = np.zeros(n)  # by the running pulse, negative for deflation [kg]
        self.direction: Valves = np.zeros(n, dtype=np.int8)  # commanded
        self.flow: Floats = np.zeros(n)  # into the channels [kg/s]
        self._rehearse(ambient)

    def _rehearse(self, ambient: float) -> None:
        """Compile or load the kernels before the first sample."""
        pressures_abs = np.full(len(self.flow), ambient)
        pulses = PulseIntegrals(len(self.flow), ambient)
        pulses.follow(SHORTEST_MEAN, pressures_abs, ambient, self._running())
        self.pulse_mass(SHORTEST_MEAN, pressures_abs, ambient)

    def _running(self) -> tuple[Floats, Floats, Valves]:
        """Coefficients, sign and direction of the running pulses."""
        return self._coefficients, self._sign, self.direction

    def _take(self, calibrations: Sequence[ChannelCalibration]) -> None:
        self._inflate = _columns(c.inflate.as_array() for c in calibrations)
        self._deflate = _columns(c.deflate.as_array() for c in calibrations)
        self._inflate_delays = _columns(c.inflate.delays for c in calibrations)
        self._deflate_delays = _columns(c.deflate.delays for c in calibrations)
        self._leak = np.array([c.leak.conductance for c in calibrations])  # [kg/(s Pa)]

    def set_calibrations(self, calibrations: Sequence[ChannelCalibration]) -> None:
        """Use these coefficients from the next pulses on; the masses estimated so far are kept.

        Raises:
            ValueError: there is not one calibration for each channel.
        """
        if len(calibrations) != len(self.direction):
            n = len(self.direction)
            raise ValueError(f"calibrations must be {n}, one per channel, got {len(calibrations)}")
        self._take(calibrations)
        self._drift.set_calibrations(calibrations)

    @property
    def mass(self) -> Floats:
        """Mass above that at rest after all valves, if switched off now, have closed (n,) [kg]."""
        return self._settled + self.moved

    @property
    def drift_bound(self) -> Floats:
        """Possible error of each estimated mass after the pulses since `set_mass` (n,) [kg].

        Two standard deviations, from the scatter of the calibration; the pulse that is running does
        not count yet (see `DriftBound`).
        """
        return self._drift.bound

    @property
    def pulses(self) -> NDArray[np.int_]:
        """Number of pulses since `set_mass`, without the running one (n,)."""
        return self._drift.pulses.copy()

    def advance(self, dt: float, pressures_abs: Floats, supply_abs: float) -> None:
        """Integrate the running pulses over the last `dt` [s], up to these absolute pressures.

        Args:
            dt: time since the last sample [s], 0 or above.
            pressures_abs: absolute channel pressures (n,) [Pa].
            supply_abs: absolute supply pressure [Pa].
        """
        integrals = self._integrals
        if some(self._sign):
            found, ended = integrals.follow(dt, pressures_abs, supply_abs, self._running())
            self.moved, self.flow = found
            if ended is not None:
                self._settle(ended)
        if self.leak_model:
            pressures = pressures_abs - integrals.ambient
            self._settled = self._settled - dt * self._leak * np.maximum(pressures, 0.0)

    def switch(self, valves: Valves, pressures_abs: Floats, supply_abs: float) -> None:
        """Set the valves commanded from now on; call it after `advance` for this sample.

        Args:
            valves: +1 inflate, -1 deflate, 0 closed (n,).
            pressures_abs: absolute channel pressures (n,) [Pa].
            supply_abs: absolute supply pressure [Pa].
        """
        if same(valves, self.direction):
            return
        changed = valves != self.direction
        self._integrals.end(changed)
        self.direction = valves.copy()
        self.flow = np.where(changed, 0.0, self.flow)
        begun = changed & (valves != 0)
        if not some(begun):
            return
        self._settle(begun & (self._sign != 0))
        self._sign = np.where(begun, valves, self._sign)
        fresh = np.where(valves > 0, self._inflate, self._deflate)
        self._coefficients = np.where(begun, fresh, self._coefficients)
        delays = np.where(valves > 0, self._inflate_delays, self._deflate_delays)
        self._integrals.begin(begun, valves, pressures_abs, supply_abs, delays)

    def _settle(self, ended: Flags) -> None:
        """Add the pulses that have ended to the settled mass."""
        if not some(ended):
            return
        values, lengths, c = self._integrals.values, self._integrals.lengths, self._coefficients
        flow = (c[1] * values[1] + c[2] * values[2]) / np.maximum(lengths, SHORTEST_MEAN)
        # a pulse that moved no air, or before `set_mass`, contributes no uncertainty
        moving = ended & (self.moved != 0)
        self._drift.add(moving, self._sign > 0, values, flow)
        self._settled = np.where(ended, self._settled + self.moved, self._settled)
        self.moved = np.where(ended, 0.0, self.moved)
        self._sign = np.where(ended, 0.0, self._sign)

    def pulse_mass(
        self, duration: float, pressures_abs: Floats, supply_abs: float
    ) -> tuple[Floats, Floats]:
        """Predict the air mass of a pulse of `duration` [s] at constant absolute pressures [Pa].

        Returns:
            Masses that an inflating pulse adds (n,) and that a deflating pulse removes (n,) [kg],
            both at least 0.
        """
        found = np.empty((2, len(pressures_abs)))
        ends = supply_abs, self._integrals.ambient
        coefficients = self._inflate, self._deflate
        delays = self._inflate_delays, self._deflate_delays
        predict_pulses(duration, pressures_abs, ends, coefficients, delays, found)
        gain, loss = found
        return gain, loss

    def lift(self, masses: Floats) -> None:
        """Increase the estimates by `masses` (n,) [kg]; running pulses and drift are kept."""
        self._settled = self._settled + masses

    def set_mass(self, channel: int, mass: float) -> None:
        """Set the estimate of a channel to `mass` [kg] and clear its drift.

        A running pulse is assumed to move no more air: this is for a channel of constant pressure.
        """
        self._settled[channel] = mass
        self.moved[channel] = 0.0
        self._coefficients[:, channel] = 0.0
        self._drift.restart(channel)


def _columns(rows: Iterable[Sequence[float] | Floats]) -> Floats:
    """Rows, one per channel, as columns (k, n)."""
    return np.ascontiguousarray(np.array(list(rows)).T)
