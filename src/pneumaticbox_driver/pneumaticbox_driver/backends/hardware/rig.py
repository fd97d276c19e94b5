"""Rig with a real box: commands and pressures; outlets open without commands and at the end."""

import atexit
import math
import threading
import time
from typing import Any, Protocol

import numpy as np
from numpy.typing import ArrayLike

from pneumaticbox_driver.arrays import Floats, Valves
from pneumaticbox_driver.backends.hardware.board_clock import BoardClock
from pneumaticbox_driver.backends.hardware.board_threads import OPENED, ReadThread, ValveThread
from pneumaticbox_driver.backends.hardware.hardware_file import HardwareError
from pneumaticbox_driver.safety import text_of

COMMAND_SILENCE_LIMIT = 0.2  # time without a command after which the outlets open [s]
BOARD_START_LIMIT = 1.0  # for closing the valves when the board is opened [s]
BOARD_END_LIMIT = 0.3  # for each call of the board at the end [s]


class ValveBoard(Protocol):
    """A board with n channels; its first call closes the valves.

    Boards named in a hardware file are called with `outlets` (n,), the numbers of the outlets
    that the channels use, from 1, with `ambient` [Pa], and with the file's `settings`; a class
    that takes `needs_answer` gets False where outlets are to be opened though nothing can be read.

    Two threads use a board: `set_valves` may be called while a `read` is running and must not wait
    for it. Two calls of the same method never overlap. `close` is called last; a call that has not
    returned for 300 ms may still be running then. A call that blocks must release Python's global
    lock, as calls of the standard library do.
    """

    def set_valves(self, valves: Valves) -> None:
        """Switch the valves (n,) without delay: +1 inflate, -1 deflate, 0 closed.

        Raises:
            OSError, HardwareError: the board cannot be reached.
        """

    def read(self) -> tuple[float, Floats]:
        """Read the pressures and the time of the reading on a monotonic clock [s].

        Returns:
            The time and absolute pressures of the channels, then of the supply (n + 1,) [Pa];
            NaN for a sensor that cannot be read.

        Raises:
            OSError, HardwareError: the board cannot be reached.
        """

    def close(self) -> None:
        """Release the board; its valves have been switched before."""


class HardwareRig:
    """A valve board with n channels; `open_rig` makes one from a hardware file.

    No call waits for the board longer than 150 ms. When no command comes for 200 ms, or the board
    does not take a command, the outlets are opened. The next reading reports this; until it has
    been read, commands that would close or inflate outlets are not carried out. `close`, which is
    also called at a regular end of the process, opens the outlets, waits until they have been open
    for `vent_time`, and releases the board.

    Args:
        board: the board; its valves are closed first.
        channels: number of channels.
        vent_time: time for which the outlets stay open before the board is released [s].
        silence_limit: time without a command after which the outlets open [s].

    Raises:
        HardwareError, OSError: the board cannot be commanded; it has been released then.
    """

    def __init__(
        self,
        board: ValveBoard,
        channels: int,
        vent_time: float,
        silence_limit: float = COMMAND_SILENCE_LIMIT,
    ) -> None:
        self._board, self._channels, self._vent_time = board, channels, vent_time
        self._open: Valves = np.full(channels, -1, dtype=np.int8)
        self._time = math.nan
        self._clock = BoardClock()
        self._closing = threading.Lock()
        self._ended = False
        self._reader = ReadThread(board.read)
        self._valves = ValveThread(board.set_valves, self._open, silence_limit)
        try:
            self._valves.start(np.zeros(channels, dtype=np.int8), BOARD_START_LIMIT)
        except BaseException:
            self._valves.finish(board.close, BOARD_END_LIMIT)
            raise
        atexit.register(self.close)

    @property
    def vent_time(self) -> float:
        """Time for which `close` opens the outlets [s]."""
        return self._vent_time

    @property
    def time(self) -> float:
        """Time of the last reading on the board's clock [s], corrected so that it counts on after a
        restart of the board; NaN before the first reading.
        """
        return self._time

    def command(self, valves: ArrayLike) -> None:
        """Switch the valves (n,): +1 inflate, -1 deflate, 0 closed.

        Raises:
            ValueError: not n valves, or one that is none of the three; nothing has moved.
            HardwareError, OSError: the board cannot be commanded, or is closed; or the outlets have
                been opened without a command, and no reading has said so yet.
        """
        wanted = np.asarray(valves)
        if wanted.shape != (self._channels,) or not np.isin(wanted, (-1, 0, 1)).all():
            raise ValueError(f"valves must be {self._channels} of -1, 0, 1, got {valves!r}")
        if self._ended:
            raise HardwareError("the board is closed: no command is carried out")
        self._valves.command(wanted.astype(np.int8))

    def read(self) -> Floats:
        """Read absolute pressures of the channels, then of the supply (n + 1,) [Pa]; NaN for a
        sensor that cannot be read.

        Raises:
            HardwareError: the board is closed, does not answer in time, returns no valid time or
                another number of pressures, or the outlets were opened for lack of commands.
            OSError: the board cannot be read.
        """
        if self._ended:
            raise HardwareError("the board is closed: it cannot be read")
        try:
            self._time, pressures = self._sound(self._reader.read())
        except (ValueError, OSError) as error:
            trouble, text = self._valves.trouble, text_of(error)
            if trouble not in text:
                raise HardwareError(f"{text}; {trouble}") from error
            raise
        if self._valves.report_opening():
            raise HardwareError(OPENED)
        return pressures

    def _sound(self, reading: Any) -> tuple[float, Floats]:
        """Check the time and pressures that the board's `read` returned; raises HardwareError."""
        try:
            time_read, pressures = reading
            values = np.array(pressures, dtype=float)  # the board may use its array again
        except (TypeError, ValueError) as error:
            raise HardwareError(
                f"the board's read must return a time and pressures, got {reading!r:.80}"
            ) from error
        if values.shape != (self._channels + 1,):
            raise HardwareError(
                f"the board must return {self._channels + 1} pressures, got {values.shape}"
            )
        return self._clock.check(time_read, time.monotonic()), values

    def close(self) -> None:
        """Open the outlets, wait for `vent_time` and release the board; later calls do nothing.

        Raises:
            HardwareError, OSError: the valves cannot be switched or the board not be released.
        """
        with self._closing:
            if self._ended:
                return
            self._ended = True
        atexit.unregister(self.close)
        try:
            self._vent()
        finally:
            self._reader.wait_idle(BOARD_END_LIMIT)
            self._valves.finish(self._board.close, BOARD_END_LIMIT)

    def _vent(self) -> None:
        """Open the outlets until they have been open for `vent_time`; an error of the board may be
        of some outlets only, and the others are open.
        """
        try:
            self._valves.command(self._open, BOARD_END_LIMIT)
        finally:
            vented = max(0.0, time.monotonic() - self._valves.open_since)
            time.sleep(max(0.0, self._vent_time - vented))

    def __enter__(self) -> "HardwareRig":
        return self

    def __exit__(self, *_: object) -> None:
        self.close()
