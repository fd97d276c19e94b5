"""Commands to the box: checked as a whole, then followed as setpoints over time."""

import math
from bisect import bisect_right
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
FIELDS = {  # of a trajectory point, by control mode
    "mass": "positions",
    "mass_flow": "velocities",
    "pressure": "effort",
    "volume": "positions",
    "time": "positions",
}


@dataclass(frozen=True)
class TrajectoryPoint:
    """Targets of the named channels at a time [s] after the start, in SI units of the mode."""

    time_from_start: float
    positions: Sequence[float] = ()
    velocities: Sequence[float] = ()
    effort: Sequence[float] = ()


@dataclass(frozen=True)
class Trajectory:
    """A checked command: values (points, channels) at times (points,) [s] after `start` [s].

    `start` is None for now.
    """

    channels: tuple[int, ...]
    start: float | None
    times: Floats
    values: Floats


@dataclass(frozen=True)
class CommandRules:
    """Checks commands against the channels' names and their control modes, in order."""

    channels: tuple[str, ...]
    modes: tuple[str, ...]

    def check(
        self, names: Sequence[str], points: Sequence[TrajectoryPoint], stamp: float = 0.0
    ) -> Trajectory:
        """Turn a message's content into a command, or refuse it whole.

        Args:
            names: channels that the points are for.
            points: targets; each mode reads its own field (`FIELDS`).
            stamp: time at which the trajectory starts [s], 0 for now.

        Raises:
            ValueError: the message names the field, what was expected and what was found.
        """
        indices = self._indices(names)
        if not points:
            raise ValueError("points: expected at least one, got none")
        if not (math.isfinite(stamp) and stamp >= 0):
            raise ValueError(f"header.stamp: expected 0 s or later, got {stamp}")
        times = _times(points)
        rows = [self._values(f"points[{k}]", indices, point) for k, point in enumerate(points)]
        return Trajectory(indices, stamp or None, times, np.array(rows))

    def _indices(self, names: Sequence[str]) -> tuple[int, ...]:
        if not names:
            raise ValueError(f"joint_names: expected channels of {list(self.channels)}, got none")
        for name in names:
            if name not in self.channels:
                known = list(self.channels)
                raise ValueError(f"joint_names: expected channels of {known}, got {name!r}")
        if len(set(names)) < len(names):
            raise ValueError(f"joint_names: expected each channel once, got {list(names)}")
        return tuple(self.channels.index(name) for name in names)

    def _values(self, key: str, indices: Sequence[int], point: TrajectoryPoint) -> list[float]:
        row = []
        for column, index in enumerate(indices):
            name = FIELDS[self.modes[index]]
            given = getattr(point, name)
            if len(given) != len(indices):
                raise ValueError(f"{key}.{name}: expected {len(indices)} values, got {len(given)}")
            value = float(given[column])
            if not math.isfinite(value):
                raise ValueError(f"{key}.{name}[{column}]: expected a finite number, got {value}")
            row.append(value)
        return row


def _times(points: Sequence[TrajectoryPoint]) -> Floats:
    before = -math.inf
    for k, point in enumerate(points):
        now = point.time_from_start
        if not (math.isfinite(now) and now >= 0):
            raise ValueError(f"points[{k}].time_from_start: expected 0 s or later, got {now}")
        if now <= before:
            raise ValueError(f"points[{k}].time_from_start: expected more than {before}, got {now}")
        before = now
    return np.array([point.time_from_start for point in points])


@dataclass
class _Course:
    """Setpoint of one channel over time: linear between the knots, constant outside."""

    times: list[float] = field(default_factory=lambda: [0.0])
    values: list[float] = field(default_factory=lambda: [math.nan])

    def at(self, time: float) -> float:
        """Return the setpoint at `time` [s], NaN before the first one."""
        after = bisect_right(self.times, time)
        if after == 0:
            return self.values[0]
        if after == len(self.times):
            return self.values[-1]
        t0, t1 = self.times[after - 1], self.times[after]
        v0, v1 = self.values[after - 1], self.values[after]
        # from no setpoint there is nothing to interpolate: wait for the first one
        return v0 if math.isnan(v0) else v0 + (v1 - v0) * (time - t0) / (t1 - t0)

    def replace_from(self, start: float, times: Floats, values: Floats) -> None:
        """Let the knots `start` + `times` [s] follow what stood until `start`."""
        held = self.at(start)
        keep = bisect_right(self.times, start)
        self.times = [*self.times[:keep], *(start + times).tolist()]
        self.values = [*self.values[:keep], *values.tolist()]
        if keep == 0 or self.times[keep - 1] < start:
            self.times.insert(keep, start)
            self.values.insert(keep, held)

    def forget_before(self, time: float) -> None:
        passed = bisect_right(self.times, time) - 1
        if passed > 0:
            del self.times[:passed], self.values[:passed]


class Setpoints:
    """Setpoints of all channels over time; NaN where there is none.

    A command replaces what its channels had planned from its start on: from the setpoint at
    that moment linearly to the first point, so a first point at time 0 is a step. Before its
    start the earlier plan goes on.
    """

    def __init__(self, channels: int) -> None:
        self._courses = [_Course() for _ in range(channels)]
        self._busy: set[int] = set()
        self._now: Floats = np.full(channels, np.nan)
        self.last_time = math.nan  # when the last of all plans ends [s]

    def take(self, command: Trajectory, now: float) -> None:
        """Follow `command` from its start, or from `now` [s]."""
        start = now if command.start is None else command.start
        for column, channel in enumerate(command.channels):
            course = self._courses[channel]
            course.forget_before(min(now, start))
            course.replace_from(start, command.times, command.values[:, column])
            self._busy.add(channel)
        end = start + float(command.times[-1])
        self.last_time = end if math.isnan(self.last_time) else max(self.last_time, end)

    def at(self, time: float) -> Floats:
        """Setpoints at `time` [s] (n,); times must not run backwards between calls."""
        for channel in tuple(self._busy):
            course = self._courses[channel]
            self._now[channel] = course.at(time)
            if time >= course.times[-1]:
                self._busy.discard(channel)
                course.forget_before(time)
        return self._now

    def hold(self) -> None:
        """Drop all plans and setpoints."""
        self.last_time = math.nan
        self._now[:] = np.nan
        self._busy.clear()
        self._courses = [_Course() for _ in self._courses]
