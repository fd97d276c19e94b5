"""Commands and valve schedules: checked as a whole, then turned into setpoints over time."""

import math
from bisect import bisect_right
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from itertools import pairwise

import numpy as np

from pneumaticbox_driver.arrays import Floats
from pneumaticbox_driver.box.ranges import Range, refusal
from pneumaticbox_driver.modes import MODES
from pneumaticbox_driver.settings import BoxSettings
from softhand_common.documents.quoted import quoted


@dataclass(frozen=True)
class TrajectoryPoint:
    """Targets of the named channels at a time [s] after the start, in SI units of the mode."""

    time_from_start: float
    positions: Sequence[float] = ()
    velocities: Sequence[float] = ()
    effort: Sequence[float] = ()


@dataclass(frozen=True)
class Trajectory:
    """A checked command: values (points, channels) at times (points,) [s] after `start` [s], or
    from now on if `start` is None.
    """

    channels: tuple[int, ...]
    start: float | None
    times: Floats
    values: Floats


@dataclass(frozen=True)
class CommandRules:
    """Checks commands for channels with these names and control modes, in order.

    `shortest_pulse` and `shortest_pause` [s] are the smallest times between the events of a
    schedule, `ranges` the ranges of the targets by mode (see `target_ranges`); a mode without a
    range has no limits.
    """

    channels: tuple[str, ...]
    modes: tuple[str, ...]
    shortest_pulse: float = 0.0
    shortest_pause: float = 0.0
    ranges: dict[str, Range] = field(default_factory=dict)

    def check(
        self, names: Sequence[str], points: Sequence[TrajectoryPoint], stamp: float = 0.0
    ) -> Trajectory:
        """Turn the content of a message into a command, or refuse it as a whole.

        Args:
            names: channels that the points are for.
            points: targets; each mode reads its own field (`MODES`).
            stamp: time at which the trajectory starts [s], 0 for now.

        Raises:
            ValueError: the message names the field, what was expected and what was found.
        """
        indices = self.check_names(names)
        modes = zip(names, (MODES[self.modes[i]] for i in indices), strict=True)
        timed = [name for name, mode in modes if mode.scheduled]
        if timed:
            raise ValueError(
                f"joint_names: expected channels in a closed-loop mode, got {timed} in mode time, "
                "which takes pneumaticbox/valve_schedule"
            )
        return self._trajectory(indices, points, stamp)

    def check_schedule(
        self, names: Sequence[str], points: Sequence[TrajectoryPoint], stamp: float = 0.0
    ) -> Trajectory:
        """Turn a valve schedule into a command, or refuse it as a whole.

        Refused are pulses and pauses shorter than the shortest ones of the valves, and a change
        between inflation and deflation without a pause.

        Args:
            names: channels that the points are for, all of them in mode time.
            points: their positions are +1 inflate, -1 deflate, 0 closed, each until the next.
            stamp: time at which the schedule starts [s], 0 for now.

        Raises:
            ValueError: the message names the field, what was expected and what was found.
        """
        indices = self.check_names(names)
        for name, index in zip(names, indices, strict=True):
            mode = self.modes[index]
            if not MODES[mode].scheduled:
                raise ValueError(
                    f"joint_names: expected channels in mode time, got {name} in {mode}"
                )
        schedule = self._trajectory(indices, points, stamp)
        self._check_events(schedule)
        return schedule

    def _check_events(self, schedule: Trajectory) -> None:
        values, times = schedule.values, schedule.times
        wrong = np.argwhere(~np.isin(values, (-1.0, 0.0, 1.0)))
        if len(wrong):
            k, column = wrong[0]
            got = values[k, column]
            raise ValueError(f"points[{k}].positions[{column}]: expected -1, 0 or 1, got {got}")
        for column, events in enumerate(values.T):
            changes = [0, *(np.flatnonzero(np.diff(events)) + 1).tolist()]
            for before, after in pairwise(changes):
                self._check_change(f"points[{after}]", column, events[[before, after]])
                least = self.shortest_pulse if events[before] else self.shortest_pause
                lasts = float(times[after] - times[before])
                if lasts < least - 1e-6:
                    what = "an open valve" if events[before] else "a closed valve"
                    raise ValueError(
                        f"points[{after}].time_from_start: expected {what} to stay as it is for "
                        f"{least * 1e3:.0f} ms at least, got {lasts * 1e3:.0f} ms"
                    )

    def _check_change(self, key: str, column: int, change: Floats) -> None:
        if change[0] * change[1] < 0 and self.shortest_pause > 0:
            raise ValueError(
                f"{key}.positions[{column}]: expected 0 between 1 and -1, for "
                f"{self.shortest_pause * 1e3:.0f} ms at least, got {change[1]:.0f}"
            )

    def _trajectory(
        self, indices: tuple[int, ...], points: Sequence[TrajectoryPoint], stamp: float
    ) -> Trajectory:
        if not points:
            raise ValueError("points: expected at least one, got none")
        if not (math.isfinite(stamp) and stamp >= 0):
            raise ValueError(f"header.stamp: expected 0 s or later, got {stamp}")
        times = _times(points)
        rows = [self._values(f"points[{k}]", indices, point) for k, point in enumerate(points)]
        return Trajectory(indices, stamp or None, times, np.array(rows))

    def check_names(self, names: Sequence[str]) -> tuple[int, ...]:
        """Indices of the channels of these names; raises ValueError unless each is a channel's name
        and none comes twice.
        """
        if not names:
            raise ValueError(
                f"joint_names: expected channels out of {list(self.channels)}, got none"
            )
        for name in names:
            if name not in self.channels:
                known = list(self.channels)
                raise ValueError(
                    f"joint_names: expected channels out of {known}, got {quoted(name)}"
                )
        if len(set(names)) < len(names):
            raise ValueError(f"joint_names: expected each channel once, got {quoted(list(names))}")
        return tuple(self.channels.index(name) for name in names)

    def _values(self, key: str, indices: Sequence[int], point: TrajectoryPoint) -> list[float]:
        row = []
        for column, index in enumerate(indices):
            mode = self.modes[index]
            name = MODES[mode].field
            given = getattr(point, name)
            if len(given) != len(indices):
                raise ValueError(f"{key}.{name}: expected {len(indices)} values, got {len(given)}")
            value = float(given[column])
            if not math.isfinite(value):
                raise ValueError(f"{key}.{name}[{column}]: expected a finite number, got {value}")
            expected = refusal(mode, index, value, self.ranges)
            if expected:
                raise ValueError(
                    f"{key}.{name}[{column}]: channel {self.channels[index]} in mode {mode}: "
                    f"expected {expected}, got {value:.6g}"
                )
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
class _Curve:
    """Setpoint of one channel over time: linear between knots, constant outside of them.

    A stepped curve keeps each value until the next knot.
    """

    times: list[float] = field(default_factory=lambda: [0.0])
    values: list[float] = field(default_factory=lambda: [math.nan])
    stepped: bool = False

    def at(self, time: float) -> float:
        """Return the setpoint at `time` [s], NaN before the first one."""
        t0, v0, t1, v1 = self.piece(time)
        return v0 + (v1 - v0) * (time - t0) / (t1 - t0)

    def piece(self, time: float) -> tuple[float, float, float, float]:
        """Return the linear piece at `time` [s] as t0, v0, t1, v1."""
        after = bisect_right(self.times, time)
        before = max(after - 1, 0)
        end = self.times[after] if after < len(self.times) else math.inf
        value = self.values[before]
        # without a setpoint there is nothing to interpolate from
        held = after == 0 or math.isinf(end) or self.stepped or math.isnan(value)
        return min(self.times[before], time), value, end, value if held else self.values[after]

    def replace_from(self, start: float, times: Floats, values: Floats) -> None:
        """Replace the curve from `start` on by knots at `start` + `times` [s]."""
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
    """Setpoints of all channels over time; NaN for none.

    A command replaces the setpoints of its channels from its start on; they first go linearly from
    the setpoint at that time to the first point, so that a first point at time 0 is a step. Until
    the start the earlier commands apply.
    """

    def __init__(self, channels: int) -> None:
        self._curves = [_Curve() for _ in range(channels)]
        self._pieces: Floats = np.ones((4, channels))  # begin, span, value at begin, rise
        self._enter_anew()
        self.last_time = math.nan  # end of all commands so far [s]

    def _enter_anew(self) -> None:
        """Let the next call of `at` look up the pieces of all curves."""
        self._until = self._stepped_until = -math.inf  # start of the next piece of any curve [s]

    def take(self, command: Trajectory, now: float) -> None:
        """Add a command from its start, or from `now` [s] if it has no start."""
        start = now if command.start is None else command.start
        for column, channel in enumerate(command.channels):
            curve = self._curves[channel]
            curve.forget_before(min(now, start))
            curve.replace_from(start, command.times, command.values[:, column])
        self._enter_anew()
        end = start + float(command.times[-1])
        self.last_time = end if math.isnan(self.last_time) else max(self.last_time, end)

    def at(self, time: float, period: float = 0.0) -> Floats:
        """Setpoints (n,) at `time` [s], which must not decrease between calls.

        period [s]: time between calls. A step of a valve schedule takes effect at the call nearest
        to its time; with 0, at the first call that is not before it.
        """
        half = 0.5 * period
        if time >= self._until or time + half >= self._stepped_until:
            self._enter(time, half)
        begin, span, value, rise = self._pieces
        return np.asarray(value + rise * ((time - begin) / span))

    def _enter(self, time: float, half: float) -> None:
        """Look up the pieces of the curves at a time [s]."""
        self._until = self._stepped_until = math.inf
        for channel, curve in enumerate(self._curves):
            moment = time + half if curve.stepped else time
            curve.forget_before(moment)
            t0, v0, t1, v1 = curve.piece(moment)
            self._pieces[:, channel] = t0, t1 - t0, v0, v1 - v0
            if curve.stepped:
                self._stepped_until = min(self._stepped_until, t1)
            else:
                self._until = min(self._until, t1)

    def set(self, channel: int, value: float, stepped: bool) -> None:
        """Drop the commands of a channel and hold `value`, NaN for none.

        Args:
            channel: index of the channel.
            value: setpoint in the unit of the channel's mode.
            stepped: whether later setpoints change in steps, not linearly.
        """
        self._curves[channel] = _Curve(values=[value], stepped=stepped)
        self._enter_anew()

    def planned(self, channel: int, time: float) -> float:
        """Setpoint of a channel at any `time` [s] by the commands so far."""
        return self._curves[channel].at(time)

    def hold(self) -> None:
        """Drop all commands and setpoints."""
        self.last_time = math.nan
        self._enter_anew()
        self._curves = [_Curve(stepped=curve.stepped) for curve in self._curves]


class CommandIntake:
    """Rules for commands, the resulting setpoints, and the time since the last command.

    Args:
        settings: settings of the box, with the modes at the start.
        ranges: ranges of the targets, by mode.
    """

    def __init__(self, settings: BoxSettings, ranges: dict[str, Range]) -> None:
        modes = settings.control_modes
        self.setpoints = Setpoints(len(modes))
        self.rules = CommandRules(
            settings.channels, modes, settings.shortest_pulse, settings.shortest_pause, ranges
        )
        self._timeout = settings.command_timeout
        self._lead, self._span = settings.command_lead, settings.command_span
        self._last = math.nan  # when the last command was taken [s]
        self._begins: list[tuple[float, tuple[int, ...]]] = []  # starts [s], and channels
        for channel, mode in enumerate(modes):
            self.setpoints.set(channel, math.nan, MODES[mode].scheduled)

    def hold(self, values: Sequence[float], now: float) -> None:
        """Drop all commands and hold `values` (n,), in the units of the modes, NaN for none; the
        timeout starts again at `now` [s].
        """
        self.drop()
        self._last = now
        for channel, value in enumerate(values):
            self.setpoints.set(channel, value, MODES[self.rules.modes[channel]].scheduled)

    def switch(self, modes: Sequence[str], values: Sequence[float]) -> tuple[int, ...]:
        """Change to other `modes` (n,); channels that change get the setpoint of `values` (n,).

        Returns:
            Indices of the channels that have changed.
        """
        changed = tuple(i for i, mode in enumerate(modes) if mode != self.rules.modes[i])
        for channel in changed:
            self.setpoints.set(channel, values[channel], MODES[modes[channel]].scheduled)
        self.rules = replace(self.rules, modes=tuple(modes))
        return changed

    def take(self, trajectory: Trajectory, now: float) -> None:
        """Add a checked command from its start, or from `now` [s] if it has no start.

        Raises:
            ValueError: the command begins too far ahead or is too long.
        """
        self._refuse_far_ahead(trajectory, now)
        start = now if trajectory.start is None else trajectory.start
        changed = trajectory.channels
        if len(trajectory.times) == 1:
            planned = self.setpoints.planned
            pairs = zip(trajectory.channels, trajectory.values[0], strict=True)
            changed = tuple(channel for channel, value in pairs if planned(channel, start) != value)
        self.setpoints.take(trajectory, now)
        self._begins.append((start, changed))
        self._last = now

    def begun(self, time: float) -> tuple[int, ...]:
        """Indices of the channels with a command that has begun since the last call, by `time` [s];
        without commands that only repeat the present setpoint.
        """
        if not self._begins:
            return ()
        begun = [channels for start, channels in self._begins if not start > time]
        self._begins = [(start, channels) for start, channels in self._begins if start > time]
        return tuple(channel for channels in begun for channel in channels)

    def _refuse_far_ahead(self, trajectory: Trajectory, now: float) -> None:
        lead = 0.0 if trajectory.start is None else trajectory.start - now
        if lead > self._lead:
            raise ValueError(
                f"header.stamp: expected at most {self._lead:g} s ahead (command_lead), "
                f"got {lead:.6g} s"
            )
        span = float(trajectory.times[-1])
        if span > self._span:
            raise ValueError(
                f"points[{len(trajectory.times) - 1}].time_from_start: expected at most "
                f"{self._span:g} s (command_span), got {span:.6g} s"
            )

    def drop(self) -> None:
        """Drop all commands and setpoints; the timeout starts again with the next command."""
        self.setpoints.hold()
        self._begins.clear()
        self._last = math.nan

    def silent(self, time: float) -> bool:
        """Whether at `time` [s] the last command ended longer ago than the timeout."""
        return 0 < self._timeout < time - max(self._last, self.setpoints.last_time)
