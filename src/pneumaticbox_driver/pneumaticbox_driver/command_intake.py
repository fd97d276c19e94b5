"""Commands and schedules taken for the channels, each by its control mode, as setpoints."""

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from pneumaticbox_driver.commands import CommandRules, Setpoints, Trajectory
from pneumaticbox_driver.settings import BoxSettings

Floats = NDArray[np.float64]


class CommandIntake:
    """Rules by which commands are checked, the setpoints that follow, and how long none has come.

    Args:
        settings: of the box; its modes are those at the start.
    """

    def __init__(self, settings: BoxSettings) -> None:
        self._settings = settings
        self.setpoints = Setpoints(len(settings.channels))
        self.modes: tuple[str, ...] = ()
        self._last = math.nan  # when the last command was taken [s]
        self.switch(settings.control_modes, np.full(len(settings.channels), np.nan))

    def switch(self, modes: Sequence[str], values: Floats) -> tuple[int, ...]:
        """Check and follow commands by other `modes`; who changes gets the setpoint of `values`.

        Returns:
            Indices of the channels that have changed.
        """
        before = self.modes or ("",) * len(modes)
        changed = tuple(i for i, mode in enumerate(modes) if mode != before[i])
        for channel in changed:
            stepped = modes[channel] == "time"
            self.setpoints.set(channel, float(values[channel]), stepped)
        settings = self._settings
        least = (settings.shortest_pulse, settings.shortest_pause)
        self.modes = tuple(modes)
        self.rules = CommandRules(settings.channels, self.modes, *least)
        return changed

    def take(self, trajectory: Trajectory, now: float) -> None:
        """Follow a checked command from its start, or from `now` [s]."""
        self.setpoints.take(trajectory, now)
        self._last = now

    def drop(self) -> None:
        """Drop all plans and setpoints; the silence of commands begins with the next one."""
        self.setpoints.hold()
        self._last = math.nan

    def silent(self, time: float) -> bool:
        """Whether the last command and all plans ended too long before `time` [s]."""
        limit = self._settings.command_timeout
        return limit > 0 and time - max(self._last, self.setpoints.last_time) > limit
