"""The regressors of equation 4.1 for the pulses under way, from samples at any distance."""

import numpy as np
from numpy.typing import NDArray

from pneumaticbox_driver.flow_model import VALVE_DELAY, flow_rates
from pneumaticbox_driver.pulse_kernel import integrate_pulses
from softhand_model.gas import AMBIENT_PRESSURE

Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]
Valves = NDArray[np.int8]


class PulseIntegrals:
    """Integrates the terms of equation 4.1 per channel; observer and calibration share it.

    A valve follows its command late, so air flows from `t_on` + opening delay to `t_off` +
    closing delay, and the integrals run over these: what is still to come counts at the present
    rate, and is replaced by what is measured until the valve has closed. With the printed
    bounds, `t_on` to `t_off`, a pulse that changes the pressure much, as it does in a small
    volume, counts flow from before the valve opens and misses that from before it closes.

    The dead volume of an inlet keeps air at the pressure that the supply has when the valve
    closes, so while inflating the switching term has `p_in` at switch-off, not at `t_on` as
    printed. Otherwise a calibration, whose channels open together and make the supply sag, gives
    coefficients for a supply that always sags so.

    `values` (5, n) are 1, the friction and the injector integral [Pa s], and the pressures
    upstream and downstream for the switching terms [Pa]; `rates` (2, n) the present integrands
    [Pa]; both are brought up to date in place.

    Args:
        channels: number of channels.
        ambient: absolute ambient pressure [Pa].
    """

    def __init__(self, channels: int, ambient: float = AMBIENT_PRESSURE) -> None:
        self.ambient = ambient
        self._delays: Floats = np.full((2, channels), VALVE_DELAY)
        self.values: Floats = np.zeros((5, channels))
        self.rates: Floats = np.zeros((2, channels))
        # time since switch-on, and commanded length so far [s]
        self._clock: Floats = np.array([np.full(channels, VALVE_DELAY), np.zeros(channels)])
        self._passed: Floats = np.zeros((2, channels))  # integrals of what has flowed
        self._open: Flags = np.zeros(channels, dtype=bool)
        self._inflating: Flags = np.zeros(channels, dtype=bool)

    @property
    def lengths(self) -> Floats:
        """Commanded durations so far (n,) [s]."""
        return self._clock[1]

    @property
    def flowing(self) -> Flags:
        """Channels whose pulse has not ended: open, or switched off and not closed yet (n,)."""
        return self._open | (self._clock[0] < self._clock[1] + self._delays[1] - 1e-9)

    def begin(
        self,
        begun: Flags,
        valves: Valves,
        pressures: Floats,
        supply: float,
        delays: Floats | None = None,
    ) -> None:
        """Start pulses on the channels `begun` (n,), now that `valves` (n,) are commanded.

        `pressures` (n,) and `supply` are absolute [Pa]; `delays` (2, n) of opening and closing
        [s], None for the nominal ones.
        """
        given = np.full_like(self._delays, VALVE_DELAY) if delays is None else delays
        self._delays = np.where(begun, given, self._delays)
        self._inflating = np.where(begun, valves > 0, self._inflating)
        self._open = self._open | begun
        upstream, downstream = self._ends(pressures, supply)
        zeros = np.zeros_like(pressures)
        start = np.array([zeros + 1.0, zeros, zeros, upstream, downstream])
        self.values = np.where(begun, start, self.values)
        self._passed = np.where(begun, 0.0, self._passed)
        self._clock = np.where(begun, 0.0, self._clock)
        self.rates = np.array(flow_rates(upstream, downstream))

    def end(self, ended: Flags) -> None:
        """Take note that the valves of the channels `ended` (n,) are switched off now."""
        self._open = self._open & ~ended

    def advance(self, dt: float, pressures: Floats, supply: float) -> None:
        """Integrate over the last `dt` [s], rates linear in between, up to these pressures."""
        if dt <= 0:
            return
        integrate_pulses(
            dt,
            pressures,
            (supply, self.ambient),
            self._open,
            self._inflating,
            self._delays,
            self._clock,
            (self.rates, self._passed, self.values),
        )

    def _ends(self, pressures: Floats, supply: float) -> tuple[Floats, Floats]:
        upstream = np.where(self._inflating, supply, pressures)
        return upstream, np.where(self._inflating, pressures, self.ambient)
