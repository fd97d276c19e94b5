"""Ways for air past the valves: leaks, burst tubes and mechanical relief valves."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from softhand_model.gas import orifice_conductance, psi
from softhand_model.pneumatics.parameters import Pneumatics

Floats = NDArray[np.float64]


class Escapes:
    """Leaks, holes and relief valves between the actuators and the surroundings.

    A leak passes mass in proportion to the gauge pressure, a hole as an orifice does. A relief
    valve begins to open at its pressure, and is wide open when the gauge pressure has risen by
    the share `accumulation` above it.

    Args:
        parameters: constants of the box.
        leak: conductance of the leaks (n,) [kg/(s Pa)].
        relief_pressures: gauge pressures (n,) [Pa] at which the relief valves begin to open; None
            without relief valves.

    Raises:
        ValueError: relief pressures of the wrong shape or not above zero.
    """

    def __init__(
        self, parameters: Pneumatics, leak: Floats, relief_pressures: ArrayLike | None
    ) -> None:
        self._ambient = parameters.ambient_pressure
        self._temperature = parameters.temperature
        self._leak = leak
        self.leaks = bool(leak.any())
        self.relieves = relief_pressures is not None
        if relief_pressures is not None:
            given = _checked_pressures(relief_pressures, len(leak))
            self._relief_opens = given + self._ambient
            self._relief_rise = given * parameters.relief.accumulation
            self._relief = self._orifice(parameters.relief.diameter)

    def _orifice(self, diameter: ArrayLike) -> Floats:
        area = np.pi / 4 * np.asarray(diameter, dtype=float) ** 2
        return orifice_conductance(area, self._temperature)

    def relieved(self, dt: float, pressure: Floats, capacity: Floats) -> Floats:
        """Air that the relief valves let off in `dt` [s].

        Args:
            dt: step [s].
            pressure: in the actuators, absolute (n,) [Pa].
            capacity: of the actuators (n,) [kg/Pa].

        Returns:
            Mass (n,), at most what brings the pressure down to where the valve closes [kg].
        """
        excess = np.maximum(pressure - self._relief_opens, 0.0)
        share = np.minimum(excess / self._relief_rise, 1.0)
        flow = share * self._relief * pressure * psi(self._ambient / pressure)
        return np.minimum(flow * dt, excess * capacity)

    def leaked(self, dt: float, pressure: Floats, capacity: Floats, holes: Floats) -> Floats:
        """Air that leaks and burst tubes let off in `dt` [s]; below ambient it comes in.

        Args:
            dt: step [s].
            pressure: in the actuators, absolute (n,) [Pa].
            capacity: of the actuators (n,) [kg/Pa].
            holes: diameters of holes (n,), 0 for none [m].

        Returns:
            Mass (n,), at most what evens out the pressures [kg].
        """
        gauge = pressure - self._ambient
        high, low = np.maximum(pressure, self._ambient), np.minimum(pressure, self._ambient)
        flow = self._leak * np.abs(gauge)
        if holes.any():
            flow = flow + self._orifice(holes) * high * psi(low / high)
        return np.copysign(np.minimum(flow * dt, np.abs(gauge) * capacity), gauge)


def _checked_pressures(pressures: ArrayLike, channels: int) -> Floats:
    given = np.asarray(pressures, dtype=float)
    if given.shape != (channels,):
        raise ValueError(f"relief_pressures must have shape ({channels},), got {given.shape}")
    if not (given > 0).all():
        raise ValueError(f"relief_pressures must be above 0 Pa, got {given.tolist()}")
    return given
