"""The regressors of equation 4.1 for the pulses under way, from samples at any distance."""

import numpy as np
from numpy.typing import NDArray

from pneumaticbox_driver.flow_model import flow_rates
from softhand_model.gas import AMBIENT_PRESSURE

Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]
Valves = NDArray[np.int8]


class PulseIntegrals:
    """Integrates the terms of equation 4.1 per channel; observer and calibration share it.

    `values` (5, n) are 1, the friction and the injector integral [Pa s], and the pressures
    upstream and downstream at switch-on [Pa]; `rates` the present integrands (n,), (n,) [Pa].

    Args:
        channels: number of channels.
        ambient: absolute ambient pressure [Pa].
    """

    def __init__(self, channels: int, ambient: float = AMBIENT_PRESSURE) -> None:
        self.ambient = ambient
        self.values: Floats = np.zeros((5, channels))
        self.rates: tuple[Floats, Floats] = (np.zeros(channels), np.zeros(channels))
        self._inflating: Flags = np.zeros(channels, dtype=bool)

    def begin(self, changed: Flags, valves: Valves, pressures: Floats, supply: float) -> None:
        """Start new pulses on the `changed` channels (n,), now that `valves` (n,) are commanded.

        `pressures` (n,) and `supply` are absolute [Pa].
        """
        self._inflating = valves > 0
        upstream, downstream = self._ends(pressures, supply)
        zeros = np.zeros_like(pressures)
        start = np.array([zeros + 1.0, zeros, zeros, upstream, downstream])
        self.values = np.where(changed, start, self.values)
        self.rates = flow_rates(upstream, downstream)

    def advance(self, dt: float, pressures: Floats, supply: float) -> None:
        """Integrate over the last `dt` [s] by the trapezoid, up to these absolute pressures."""
        before = self.rates
        self.rates = flow_rates(*self._ends(pressures, supply))
        self.values[1] += (0.5 * dt) * (self.rates[0] + before[0])
        self.values[2] += (0.5 * dt) * (self.rates[1] + before[1])

    def _ends(self, pressures: Floats, supply: float) -> tuple[Floats, Floats]:
        upstream = np.where(self._inflating, supply, pressures)
        return upstream, np.where(self._inflating, pressures, self.ambient)
