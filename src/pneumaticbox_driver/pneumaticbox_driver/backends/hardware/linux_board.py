"""The thesis's kind of box: coils on GPIO lines, sensors on analog inputs (Table 4.1)."""

import time
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from pneumaticbox_driver.arrays import Floats, Valves
from pneumaticbox_driver.backends.hardware.inputs import IioInputs
from pneumaticbox_driver.backends.hardware.lines import OutputLines


class LinuxBoard:
    """Drives the outlets' coils and reads the sensors; coils not in use stay off.

    Coils that go off are switched before coils that go on, so never both of a valve are on.

    Args:
        lines: of all outlets of the box, inflate and deflate in turn.
        inputs: sensors of the channels, then of the supply.
        outlets: number of each channel's outlet, from 1 (n,).
    """

    def __init__(self, lines: OutputLines, inputs: IioInputs, outlets: Sequence[int]) -> None:
        self.inputs = inputs
        self._lines = lines
        self._first = 2 * (np.asarray(outlets) - 1)  # line of the inflating coil (n,)
        self._on: NDArray[np.bool_] = np.zeros(2 * len(outlets), dtype=bool)
        self._known = True  # whether `_on` is what the lines carry

    def set_valves(self, valves: Valves) -> None:
        """Switch the coils to `valves` (n,); what is as it was is not written again.

        Raises:
            HardwareError: a line cannot be set.
        """
        valves = np.asarray(valves)
        wanted = np.concatenate([valves > 0, valves < 0])
        changed = (wanted != self._on) | (not self._known)
        self._known = False  # should switching fail in between: all are written again then
        for state in (False, True):
            coils = np.flatnonzero(changed & (wanted == state)).tolist()
            if coils:
                self._lines.switch({self._line(coil): state for coil in coils})
        self._on, self._known = wanted, True

    def _line(self, coil: int) -> int:
        kind, channel = divmod(coil, len(self._first))
        return int(self._first[channel]) + kind

    def read(self) -> tuple[float, Floats]:
        """Read the monotonic time [s] and the absolute pressures then (n + 1,) [Pa]."""
        return time.monotonic(), self.inputs.read()

    def close(self) -> None:
        """Give lines and files back."""
        try:
            self._lines.release()
        finally:
            self.inputs.close()
