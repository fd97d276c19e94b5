"""Slow 5/3 valves (section 4.3), and outlets that open when commands stop."""

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from softhand_common.numerics.arrays import Array, Spools
from softhand_model.pneumatics.parameters import Range, Valve

PLANT_SILENCE_LIMIT = 0.25  # of the plant's own time [s]


class Valves:
    """Spools of all channels. States and commands: +1 inflate, -1 deflate, 0 closed.

    A spool goes from one outlet to the other only through the closed position, so inlet and
    outlet are never open together. A command that is withdrawn before its delay has passed does
    nothing: this is why there is a smallest pulse.
    """

    def __init__(
        self, parameters: Valve, tolerances: np.random.Generator, channels: int, slots: int
    ) -> None:
        """Draw the delays of `slots` valves of one box and keep the first `channels`.

        Args:
            parameters: ranges and jitter of the delays.
            tolerances: generator of the box; the same box gives the same valves.
            channels: number of channels in use.
            slots: number of channels that the box has.
        """
        self._parameters = parameters
        # rows: deflating coil, inflating coil
        self.opening_delay = tolerances.uniform(*parameters.opening_delay, (2, slots))[:, :channels]
        self.closing_delay = tolerances.uniform(*parameters.closing_delay, (2, slots))[:, :channels]
        self.reset(channels)

    def reset(self, channels: int) -> None:
        """Close the spools of a number of channels and drop pending commands."""
        self.state: Spools = np.zeros(channels, dtype=np.int8)
        self._command: Spools = np.zeros(channels, dtype=np.int8)
        self._opens: Array = np.full(channels, np.inf)
        self._closes: Array = np.full(channels, np.inf)
        self.next_change = np.inf  # when the next spool will move [s]

    def commanded(self, valves: ArrayLike) -> bool:
        """Whether the last command was already these `valves` (channels,), whose values are not
        checked.
        """
        given, own = np.asarray(valves), self._command
        alike = given.dtype == own.dtype and given.shape == own.shape
        return alike and given.tobytes() == own.tobytes()

    def command(self, time: float, valves: Spools, noise: np.random.Generator) -> None:
        """Switch the coils at `time` [s] to `valves` (channels,); `noise` draws the jitter."""
        if self.commanded(valves):
            return
        changed = valves != self._command
        coil = (valves > 0).astype(int)
        held = (self.state > 0).astype(int)
        column = np.arange(len(valves))
        opening = self._jittered(
            self.opening_delay[coil, column], self._parameters.opening_delay, noise
        )
        closing = self._jittered(
            self.closing_delay[held, column], self._parameters.closing_delay, noise
        )
        self._opens = np.where(changed, time + opening, self._opens)
        self._closes = np.where(changed, time + closing, self._closes)
        self._command = valves.copy()
        self._plan()

    def _jittered(self, delay: Array, bounds: Range, noise: np.random.Generator) -> Array:
        drawn = noise.normal(0.0, self._parameters.delay_jitter, delay.shape)
        return np.asarray(np.clip(delay + drawn, *bounds))

    def advance(self, time: float) -> Spools:
        """Move the spools up to `time` [s] and return their states (channels,)."""
        if time < self.next_change:
            return self.state
        leaves = (self.state != self._command) & (self.state != 0) & (time >= self._closes)
        closed = np.where(leaves, 0, self.state)
        arrives = (closed == 0) & (self._command != 0) & (time >= self._opens)
        self.state = np.where(arrives, self._command, closed).astype(np.int8)
        self._plan()
        return self.state

    def _plan(self) -> None:
        waits = np.where(self.state == 0, self._opens, self._closes)
        self.next_change = float(np.min(waits, where=self.state != self._command, initial=np.inf))

    def save(self) -> dict[str, Any]:
        """Return a copy of the changing state."""
        return {
            "state": self.state.copy(),
            "command": self._command.copy(),
            "opens": self._opens.copy(),
            "closes": self._closes.copy(),
        }

    def restore(self, saved: dict[str, Any]) -> None:
        """Restore what `save` returned."""
        self.state = saved["state"].copy()
        self._command = saved["command"].copy()
        self._opens = saved["opens"].copy()
        self._closes = saved["closes"].copy()
        self._plan()


class CommandWatch:
    """Stores the last valve command, and opens every outlet after a time without commands.

    Valves without a driver must not stay as they are: a driver that died with an inlet open
    would burst the hand. Every command counts as a sign of life, also one that changes nothing.

    >>> watch = CommandWatch(channels=2)
    >>> watch.receive(0.0, [1, 0])
    >>> watch.valves(0.2).tolist(), watch.valves(0.3).tolist()
    ([1, 0], [-1, -1])
    """

    def __init__(self, channels: int) -> None:
        """Start with closed valves at time 0, for a number of channels."""
        self._vent: Spools = np.full(channels, -1, dtype=np.int8)
        self.reset(0.0)

    def reset(self, time: float) -> None:
        """Close the valves and restart the time without commands at `time` [s]."""
        self._last = time
        self._valves: Spools = np.zeros_like(self._vent)

    def receive(self, time: float, valves: ArrayLike) -> None:
        """Set a command at the plant's `time` [s]: +1 inflate, -1 deflate, 0 closed per channel.

        Raises:
            ValueError: wrong number of channels, or another value than -1, 0, 1.
        """
        self._valves = checked_valves(valves, len(self._vent))
        self._last = time

    def silent(self, time: float) -> bool:
        """Whether at `time` [s] the last command is longer ago than the limit."""
        return time - self._last > PLANT_SILENCE_LIMIT + 1e-9

    def valves(self, time: float) -> Spools:
        """Valves at `time` [s]: the last command, or all outlets open without commands."""
        return self._vent if self.silent(time) else self._valves


def checked_valves(valves: ArrayLike, channels: int) -> Spools:
    """Return valve commands (channels,) as integers in {-1, 0, 1}.

    Raises:
        ValueError: wrong shape or another value, NaN included.

    >>> checked_valves([1.0, 0.0, -1.0], 3)
    array([ 1,  0, -1], dtype=int8)
    """
    given = np.asarray(valves)
    if given.shape != (channels,):
        raise ValueError(f"valves must have shape ({channels},), got {given.shape}")
    for value in given.tolist():
        if value not in (-1, 0, 1):
            raise ValueError(f"valves must be -1, 0 or 1, got {value}")
    return given.astype(np.int8)
