"""Leaks, relief valves, and faults of the box that a safe driver must handle."""

from __future__ import annotations

import copy
import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from softhand_common.numerics.arrays import Array, Spools
from softhand_model.gas import orifice_conductance, psi
from softhand_model.pneumatics.parameters import Pneumatics

BURST_DIAMETER = 1e-3  # [m]
BLEED_DIAMETER = 1e-3  # of the hole through which a lost supply's reservoir empties [m]


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
        self, parameters: Pneumatics, leak: Array, relief_pressures: ArrayLike | None
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
        self.any = self.leaks or self.relieves

    def _orifice(self, diameter: ArrayLike) -> Array:
        area = np.pi / 4 * np.asarray(diameter, dtype=float) ** 2
        return orifice_conductance(area, self._temperature)

    def relieved(self, dt: float, pressure_abs: Array, capacity: Array) -> Array:
        """Air that leaves through the relief valves in `dt` [s].

        Args:
            dt: step [s].
            pressure_abs: in the actuators, absolute (n,) [Pa].
            capacity: air per pressure of the actuators (n,) [kg/Pa].

        Returns:
            Mass (n,), at most what brings the pressure down to where the valve closes [kg].
        """
        excess = np.maximum(pressure_abs - self._relief_opens, 0.0)
        share = np.minimum(excess / self._relief_rise, 1.0)
        flow = share * self._relief * pressure_abs * psi(self._ambient / pressure_abs)
        return np.minimum(flow * dt, excess * capacity)

    def leaked(self, dt: float, pressure_abs: Array, capacity: Array, holes: Array) -> Array:
        """Air that leaves through leaks and burst tubes in `dt` [s]; negative below ambient.

        Args:
            dt: step [s].
            pressure_abs: in the actuators, absolute (n,) [Pa].
            capacity: air per pressure of the actuators (n,) [kg/Pa].
            holes: diameters of holes (n,), 0 for none [m].

        Returns:
            Mass (n,), at most what evens out the pressures [kg].
        """
        gauge = pressure_abs - self._ambient
        high, low = np.maximum(pressure_abs, self._ambient), np.minimum(pressure_abs, self._ambient)
        flow = self._leak * np.abs(gauge)
        if holes.any():
            flow = flow + self._orifice(holes) * high * psi(low / high)
        return np.copysign(np.minimum(flow * dt, np.abs(gauge) * capacity), gauge)


def _checked_pressures(pressures: ArrayLike, channels: int) -> Array:
    given = np.asarray(pressures, dtype=float)
    if given.shape != (channels,):
        raise ValueError(f"relief_pressures must have shape ({channels},), got {given.shape}")
    if not (given > 0).all():
        raise ValueError(f"relief_pressures must be above 0 Pa, got {given.tolist()}")
    return given


class Faults:
    """Faults of a plant; there are none at the start and after `clear`.

    Channels are given by name or index, sensors by index in the order of the readings (the last
    one is the supply's). The plant asks for the effect in each of its steps.

    >>> faults = Faults(["a", "b"])
    >>> faults.stick_valve("b", 1)
    >>> faults.spools(np.array([0, -1], dtype=np.int8)).tolist()
    [0, 1]
    """

    def __init__(self, channels: Sequence[str]) -> None:
        self._channels = tuple(channels)
        self.reset()

    def reset(self) -> None:
        """Remove all faults and the stored readings."""
        self._last: Array | None = None
        self.clear()

    def clear(self) -> None:
        """Remove all faults."""
        self._stuck: dict[int, int] = {}
        self._sensors: dict[int, float | None] = {}
        self.holes: Array = np.zeros(len(self._channels))  # diameters [m]
        self.burst_any = False
        self.supply_bleed = 0.0  # diameter of the reservoir's hole, 0 with a sound supply [m]

    def stick_valve(self, channel: int | str, state: int) -> None:
        """Hold a spool at `state` from now on: +1 inflating, -1 deflating, 0 closed.

        Raises:
            ValueError: another state, or no such channel.
        """
        if state not in (-1, 0, 1):
            raise ValueError(f"state must be -1, 0 or 1, got {state}")
        self._stuck[self._index(channel)] = int(state)

    def burst(self, channel: int | str, diameter: float = BURST_DIAMETER) -> None:
        """Open a hole of `diameter` [m] from a channel's actuator to the surroundings.

        Raises:
            ValueError: `diameter` is not above zero, or no such channel.
        """
        self.holes[self._index(channel)] = _checked_diameter(diameter)
        self.burst_any = True

    def stick_sensor(self, index: int) -> None:
        """Freeze a reading at its last value, or at the next one if there is none.

        Raises:
            ValueError: no such sensor.
        """
        self._check_sensor(index)
        self._sensors[index] = None if self._last is None else float(self._last[index])

    def lose_sensor(self, index: int) -> None:
        """Make a reading NaN, as from a broken wire.

        Raises:
            ValueError: no such sensor.
        """
        self._check_sensor(index)
        self._sensors[index] = math.nan

    def lose_supply(self, diameter: float = BLEED_DIAMETER) -> None:
        """Shut the regulator and let the reservoir empty through a hole of `diameter` [m].

        Raises:
            ValueError: `diameter` is not above zero.
        """
        self.supply_bleed = _checked_diameter(diameter)

    def spools(self, states: Spools) -> Spools:
        """States (n,) of the spools, including stuck ones."""
        if not self._stuck:
            return states
        held = states.copy()
        for channel, state in self._stuck.items():
            held[channel] = state
        return held

    def readings(self, fresh: Array) -> Array:
        """Readings (channels and supply,) [Pa] with faults, from those of working sensors."""
        for index, value in self._sensors.items():
            if value is None:
                self._sensors[index] = float(fresh[index])
            else:
                fresh[index] = value
        self._last = fresh.copy()
        return fresh

    def save(self) -> dict[str, Any]:
        """Return a copy of the state."""
        return copy.deepcopy(vars(self))

    def restore(self, saved: dict[str, Any]) -> None:
        """Restore what `save` returned."""
        vars(self).update(copy.deepcopy(saved))

    def _index(self, channel: int | str) -> int:
        if isinstance(channel, str) and channel in self._channels:
            return self._channels.index(channel)
        if isinstance(channel, int) and 0 <= channel < len(self._channels):
            return channel
        raise ValueError(f"channel must be one of {', '.join(self._channels)}, got {channel}")

    def _check_sensor(self, index: int) -> None:
        if not 0 <= index <= len(self._channels):
            raise ValueError(f"index must be 0 to {len(self._channels)}, got {index}")


def _checked_diameter(diameter: float) -> float:
    if not (diameter > 0 and math.isfinite(diameter)):
        raise ValueError(f"diameter must be above 0 m, got {diameter}")
    return float(diameter)
