"""Faults of the bench, to be set at any time: what a safe driver has to survive."""

from __future__ import annotations

import copy
import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Spools = NDArray[np.int8]
BURST_DIAMETER = 1e-3  # [m]
BLEED_DIAMETER = 1e-3  # of the hole through which a lost supply's reservoir empties [m]


class Faults:
    """What is broken on a plant; all is well at the start and after `clear`.

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
        """Repair everything, and forget the last readings."""
        self._last: Floats | None = None
        self.clear()

    def clear(self) -> None:
        """Repair everything."""
        self._stuck: dict[int, int] = {}
        self._sensors: dict[int, float | None] = {}
        self.holes: Floats = np.zeros(len(self._channels))  # diameters [m]
        self.burst_any = False
        self.supply_bleed = 0.0  # diameter of the reservoir's hole, 0 with a sound supply [m]

    def stick_valve(self, channel: int | str, state: int) -> None:
        """Hold a spool at `state` at once: +1 inflating, -1 deflating, 0 closed.

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
        """Freeze a reading at its last value, or at the first one still to come.

        Raises:
            ValueError: no such sensor.
        """
        self._check_sensor(index)
        self._sensors[index] = None if self._last is None else float(self._last[index])

    def lose_sensor(self, index: int) -> None:
        """Let a reading be NaN, as from a broken wire.

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
        """States (n,) of the spools, those that are stuck where they are stuck."""
        if not self._stuck:
            return states
        held = states.copy()
        for channel, state in self._stuck.items():
            held[channel] = state
        return held

    def readings(self, fresh: Floats) -> Floats:
        """Readings (n + 1,) [Pa] as the sensors give them, out of those of sound sensors."""
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
        """Go back to what `save` returned."""
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
