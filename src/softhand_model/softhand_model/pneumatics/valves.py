"""Slow 5/3 valves: the spools follow the electrical command after a delay (section 4.3)."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from softhand_model.pneumatics.parameters import Range, Valve

Floats = NDArray[np.float64]


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
        """Close all spools, with no command under way."""
        self.state: NDArray[np.int8] = np.zeros(channels, dtype=np.int8)
        self._command: NDArray[np.int8] = np.zeros(channels, dtype=np.int8)
        self._opens: Floats = np.full(channels, np.inf)
        self._closes: Floats = np.full(channels, np.inf)
        self.next_change = np.inf  # when the next spool will move [s]

    def command(self, time: float, valves: NDArray[np.int8], noise: np.random.Generator) -> None:
        """Switch the coils at `time` [s] to `valves` (channels,); `noise` draws the jitter."""
        if valves.tobytes() == self._command.tobytes():
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

    def _jittered(self, delay: Floats, bounds: Range, noise: np.random.Generator) -> Floats:
        drawn = noise.normal(0.0, self._parameters.delay_jitter, delay.shape)
        return np.asarray(np.clip(delay + drawn, *bounds))

    def advance(self, time: float) -> NDArray[np.int8]:
        """Move the spools to where they are at `time` [s] and return their states (channels,)."""
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
        """Go back to what `save` returned."""
        self.state = saved["state"].copy()
        self._command = saved["command"].copy()
        self._opens = saved["opens"].copy()
        self._closes = saved["closes"].copy()
        self._plan()
