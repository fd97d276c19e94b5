"""What a series of schedule commands asks of each channel over time."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from softhand_bringup.bags.reading import Command

Array = NDArray[np.float64]


def commanded_masses(commands: Sequence[Command], channels: Sequence[str], time: Array) -> Array:
    """Commanded air mass of every channel (k, n) [kg] at the times (k,) [s].

    A command replaces what was scheduled from its start on; its points are joined by straight lines
    that begin at the value then commanded, and the last point is held. Before the first command the
    value is zero, the fill at rest.

    Args:
        commands: in the order in which they came; positions in [kg].
        channels: order of the columns; a channel that a command does not name keeps its schedule.
        time: rising times [s].
    """
    masses = np.zeros((len(time), len(channels)))
    for command in commands:
        after = time >= command.start
        for column, channel in enumerate(channels):
            if channel in command.names and command.position.size:
                points = command.position[:, command.names.index(channel)]
                begin = float(np.interp(command.start, time, masses[:, column]))
                masses[after, column] = _follow(command, points, begin, time[after])
    return masses


def _follow(command: Command, points: Array, begin: float, time: Array) -> Array:
    times = command.time_from_start
    if times[0] > 0.0:
        times, points = np.concatenate([[0.0], times]), np.concatenate([[begin], points])
    return np.interp(time - command.start, times, points)
