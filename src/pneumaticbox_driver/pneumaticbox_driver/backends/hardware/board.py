"""Valve board: what the driver asks of real hardware."""

from typing import Protocol

from pneumaticbox_driver.arrays import Floats, Valves


class HardwareError(ValueError):
    """A device that is not there, may not be used or has failed."""


class ValveBoard(Protocol):
    """A board with n channels; before anything else its valves are commanded closed.

    Boards named in a hardware file are called with `outlets` (n,), the numbers of the outlets
    that the channels use, from 1, with `ambient` [Pa], and with the file's `settings`.
    """

    def set_valves(self, valves: Valves) -> None:
        """Switch the valves (n,): +1 inflate, -1 deflate, 0 closed; at once, without waiting.

        Raises:
            OSError: the board cannot be reached (HardwareError will do, too).
        """

    def read(self) -> tuple[float, Floats]:
        """Read the time [s], of a clock that is never set back, and the pressures then.

        Returns:
            The time and absolute pressures of the channels, then of the supply (n + 1,) [Pa];
            NaN for a sensor that cannot be read.
        """

    def close(self) -> None:
        """Give the board back; the valves were commanded before."""
