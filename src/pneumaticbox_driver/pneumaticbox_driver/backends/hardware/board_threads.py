"""Threads that call a valve board, so that a call that blocks does not block the driver."""

import math
import threading
import time
from collections.abc import Callable
from queue import Empty, SimpleQueue
from typing import Any, cast

from pneumaticbox_driver.arrays import Valves
from pneumaticbox_driver.backends.hardware.hardware_file import HardwareError
from pneumaticbox_driver.safety import one_line, text_of

BOARD_CALL_LIMIT = 0.15  # for a call of the board [s]
OVERDUE_LIMIT = 0.02  # additional wait for an overdue call before the next one [s]
RETRY_PERIOD = 0.05  # between attempts to open the outlets [s]
OPENED = "no command in time: the outlets have been opened"


class ReadThread:
    """Reads a board in its own thread; a reading that comes too late is discarded.

    Args:
        read: the board's method `read`.
    """

    def __init__(self, read: Callable[[], Any]) -> None:
        self._read = read
        self._requests: SimpleQueue[None] = SimpleQueue()
        self._answers: SimpleQueue[tuple[Any, Exception | None]] = SimpleQueue()
        self._busy = False
        threading.Thread(target=self._run, name="board read", daemon=True).start()

    def _run(self) -> None:
        while True:
            self._requests.get()
            self._answers.put(_outcome(self._read))

    def read(self) -> Any:
        """Return what the board's `read` returns.

        Raises:
            HardwareError: the board's `read` has not returned within 150 ms.
            Exception: any error that the board's `read` raises.
        """
        if not self.wait_idle(OVERDUE_LIMIT):
            raise HardwareError(_not_returned("read"))
        self._busy = True
        self._requests.put(None)
        try:
            value, error = self._answers.get(timeout=BOARD_CALL_LIMIT)
        except Empty:
            raise HardwareError(_not_returned("read")) from None
        self._busy = False
        if error is not None:
            raise error
        return value

    def wait_idle(self, limit: float) -> bool:
        """Wait at most `limit` [s] for an overdue reading; returns whether none is running."""
        if self._busy:
            try:
                self._answers.get(timeout=limit)
            except Empty:
                return False
            self._busy = False
        return True


class ValveThread:
    """Switches a board's valves in its own thread.

    When no command has come for `silence_limit` since the last one, or when the board has not
    taken it, the outlets are opened, every 50 ms anew until the next command. Until the user has
    asked by `report_opening`, only a command that leaves them open is taken.

    `trouble` is why the board did not take the valves last time, "" when it did. `open_since` is
    the monotonic time since which all outlets have been open, infinite when they are not [s].

    Args:
        set_valves: the board's method `set_valves`.
        outlets_open: valves that open the outlets (n,).
        silence_limit: time without a command after which the outlets open [s].
    """

    def __init__(
        self, set_valves: Callable[[Valves], None], outlets_open: Valves, silence_limit: float
    ) -> None:
        self.trouble, self.open_since = "", math.inf
        self._silent = False  # opened without a command, and no command since
        self._openings = self._reported = 0  # without a command, and those that the user knows of
        self._set_valves, self._silence_limit = set_valves, silence_limit
        self._open: Valves = outlets_open.copy()
        self._open.setflags(write=False)
        self._changed = threading.Condition()
        self._wanted: Valves | None = None
        self._give_back: Callable[[], None] | None = None
        self._asked = self._done = 0  # number of the newest request, and of the last one done
        self._error: Exception | None = None
        self._due = math.inf  # monotonic time at which the outlets are to be opened [s]
        threading.Thread(target=self._run, name="board valves", daemon=True).start()

    def start(self, valves: Valves, limit: float) -> None:
        """Switch the valves (n,) as `command` does, before the first command; the silence limit
        does not apply until then.
        """
        self._request(valves, math.inf, limit)

    def command(self, valves: Valves, limit: float = BOARD_CALL_LIMIT) -> None:
        """Switch the board's valves (n,) and wait for that at most `limit` [s].

        Raises:
            HardwareError: this call of the board, or one before it, has not returned in time; or
                the outlets have been opened without a command, which is not reported yet.
            Exception: what the board raises.
        """
        self._request(valves, time.monotonic() + self._silence_limit, limit)

    def report_opening(self) -> bool:
        """Whether the outlets were opened without a command since this was asked last."""
        with self._changed:
            news = self._openings > self._reported
            self._reported = self._openings
        return news

    def finish(self, give_back: Callable[[], None], limit: float) -> None:
        """Call `give_back` and end the thread; raises the errors of `command`."""
        with self._changed:
            self._give_back = give_back
            self._await_done("close", limit)

    def _request(self, valves: Valves, due: float, limit: float) -> None:
        with self._changed:
            if self._openings > self._reported and (valves != -1).any():
                raise HardwareError(OPENED)
            self._wanted, self._due, self._silent = valves, due, False
            self._await_done("set_valves", limit)

    def _await_done(self, call: str, limit: float) -> None:
        overdue = self._done < self._asked
        self._asked += 1
        number = self._asked
        self._changed.notify_all()
        limit = min(limit, OVERDUE_LIMIT) if overdue else limit
        if not self._changed.wait_for(lambda: self._done >= number, limit):
            self.trouble = f"{_not_returned(call)}: the valves may be unchanged"
            raise HardwareError(self.trouble)
        if self._error is not None:
            raise self._error

    def _run(self) -> None:
        """Serve requests until the board is given back; no error ends that before."""
        given_back = False
        while not given_back:
            try:
                given_back = self._serve()
            except BaseException:  # noqa: BLE001 nobody else can open the outlets
                with self._changed:
                    error = HardwareError("the thread of the valves has failed")
                    self._note(self._open, self._asked, error)
                    self._changed.notify_all()
                    given_back = self._give_back is not None

    def _serve(self) -> bool:
        """Do the next request; whether that was to give the board back."""
        with self._changed:
            valves, number = self._next(), self._asked
        call = self._give_back if valves is None else _bound(self._set_valves, valves)
        _, error = _outcome(cast(Callable[[], None], call))  # `_next` waits for one of both
        with self._changed:
            self._note(valves, number, error)
            self._changed.notify_all()
        return valves is None

    def _next(self) -> Valves | None:
        """Wait for the next valves to switch (n,); None when the board is to be released."""
        while self._wanted is None and self._give_back is None:
            left = self._due - time.monotonic()
            if left > 0:
                self._changed.wait(None if math.isinf(left) else left)
            else:
                self._openings += not self._silent
                self._silent = True
                return self._open
        valves, self._wanted = self._wanted, None
        return valves

    def _note(self, valves: Valves | None, number: int, error: Exception | None) -> None:
        self._done, self._error = number, error
        self.trouble = "" if error is None else text_of(error)
        if valves is None or error is not None or (valves != -1).any():
            self.open_since = math.inf
        else:
            self.open_since = min(self.open_since, time.monotonic())
        if self._wanted is None and (self._silent or error is not None):
            self._due = time.monotonic() + RETRY_PERIOD


def _bound(call: Callable[[Valves], None], valves: Valves) -> Callable[[], None]:
    return lambda: call(valves.copy())  # a board may change the array that it is given


def _outcome(call: Callable[[], Any]) -> tuple[Any, Exception | None]:
    """Result and error of a call of the board, for the thread that asked for it."""
    try:
        return call(), None
    except Exception as error:  # noqa: BLE001 boards are not ours
        return None, error
    except BaseException as error:  # noqa: BLE001 as SystemExit, which must end no thread
        return None, HardwareError(f"the board raised {one_line(error)}")


def _not_returned(call: str) -> str:
    return f"the board's {call} has not returned in time"
