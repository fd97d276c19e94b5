"""Bench of a real box: commands in, pressures out, outlets open in silence and at the end."""

import atexit
import contextlib
import math
import threading
import time
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike

from pneumaticbox_driver.arrays import Floats, Valves
from pneumaticbox_driver.backends.hardware.hardware_file import HardwareError
from pneumaticbox_driver.safety import SILENCE_LIMIT


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


class HardwareBench:
    """A valve board with n channels; `open_bench` makes one from a hardware file.

    When no command comes for 250 ms it opens the outlets, as the
    simulator does. At `close`, which a regular end of the process calls too, it opens them, waits
    and gives the board back.

    Args:
        board: whose valves are closed first.
        channels: how many there are.
        vent_time: for which the outlets stay open before the board is given back [s].
        silence_limit: without a command before the outlets open [s].

    Raises:
        HardwareError, OSError: the board cannot be commanded; it has been given back then.
    """

    def __init__(
        self,
        board: ValveBoard,
        channels: int,
        vent_time: float,
        silence_limit: float = SILENCE_LIMIT,
    ) -> None:
        self._board, self._channels, self._vent_time = board, channels, vent_time
        self._open: Valves = np.full(channels, -1, dtype=np.int8)
        self._time = math.nan
        self._silence_limit = silence_limit
        self._heard = math.inf  # no command yet: nothing has moved
        self._lock = threading.Lock()  # the board is used from the watch's thread, too
        self._ended = threading.Event()
        try:
            board.set_valves(np.zeros(channels, dtype=np.int8))
        except BaseException:
            board.close()
            raise
        atexit.register(self.close)
        threading.Thread(target=self._watch_silence, daemon=True).start()

    @property
    def time(self) -> float:
        """Time of the last reading on the board's clock [s]; NaN before the first."""
        return self._time

    def command(self, valves: ArrayLike) -> None:
        """Switch the valves (n,): +1 inflate, -1 deflate, 0 closed.

        Raises:
            ValueError: not n valves, or one that is none of the three; nothing has moved.
            HardwareError, OSError: the board cannot be commanded, or is closed.
        """
        wanted = np.asarray(valves)
        if wanted.shape != (self._channels,) or not np.isin(wanted, (-1, 0, 1)).all():
            raise ValueError(f"valves must be {self._channels} of -1, 0, 1, got {valves!r}")
        with self._lock:
            if self._ended.is_set():
                raise HardwareError("the bench is closed: no command is taken")
            self._heard = time.monotonic()
            self._board.set_valves(wanted.astype(np.int8))

    def read(self) -> Floats:
        """Read absolute pressures: channels, then supply (n + 1,) [Pa]; NaN for no reading.

        Raises:
            HardwareError: the board is closed, or gives another number of pressures.
        """
        with self._lock:
            if self._ended.is_set():
                raise HardwareError("the bench is closed: there is nothing to read")
            self._time, pressures = self._board.read()
        if np.shape(pressures) != (self._channels + 1,):
            raise HardwareError(
                f"the board must read {self._channels + 1} pressures, got {np.shape(pressures)}"
            )
        return np.asarray(pressures, dtype=float)

    def close(self) -> None:
        """Open the outlets, wait for `vent_time` and give the board back; once is enough."""
        with self._lock:
            if self._ended.is_set():
                return
            self._ended.set()
        atexit.unregister(self.close)
        try:
            self._board.set_valves(self._open)
            time.sleep(self._vent_time)
        finally:
            self._board.close()

    def __enter__(self) -> "HardwareBench":
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def _watch_silence(self) -> None:
        """Open the outlets when the driver's loop hangs; the next command takes over again."""
        while not self._ended.wait(self._silence_limit / 5):
            with self._lock:
                silent = time.monotonic() - self._heard > self._silence_limit
                if silent and not self._ended.is_set():
                    self._vent_silently()

    def _vent_silently(self) -> None:
        # tried again at the next look, whatever a board's code raises; the next command tells it
        with contextlib.suppress(Exception):
            self._board.set_valves(self._open)
