"""Compares a board's clock with that of the computer."""

import math
import numbers
from typing import Any

from pneumaticbox_driver.backends.hardware.hardware_file import HardwareError

LAG_LIMIT = 0.15  # by which a reading may be older than the freshest ones [s]
CLOCK_DRIFT = 1e-3  # by which a sound clock may run slow [-]
RESTART_TIME = 0.5  # for which a clock that was set back has to keep step before it counts [s]


class BoardClock:
    """Refuses readings of a clock that stands still, runs slow or is set back.

    How far the board's time is behind the computer's is compared with the least that was seen. A
    clock that was set back, as by a restart of the board, is refused until it has kept step with
    the computer's for 0.5 s. From then on its time counts on as if it had never been set back.
    """

    def __init__(self) -> None:
        self._least = math.inf  # computer's time less the board's [s]
        self._kept = math.nan  # the same at the last reading that was accepted [s]
        self._last = math.nan  # computer's time of the last reading [s]
        self._given = -math.inf  # board's time of the last reading [s]
        self._shift = 0.0  # by which the board's clock was set back in all [s]
        self._set_back = False  # and has not kept step for long enough yet
        self._since = math.nan  # computer's time since which it has kept step [s]
        self._low = self._high = math.nan  # between which it was behind since then [s]

    def check(self, time: Any, now: float) -> float:
        """Return the time of a reading that was taken just before `now` [s, monotonic].

        Raises:
            HardwareError: the time is not a finite number, or is more than 150 ms behind.
        """
        if not isinstance(time, numbers.Real) or not math.isfinite(time):
            raise HardwareError(f"the board's time must be a finite number [s], got {time!r:.80}")
        given = float(time)
        self._follow_restart(given, now)
        behind = now - (given + self._shift)
        passed = 0.0 if math.isnan(self._last) else now - self._last
        self._least = min(behind, self._least + CLOCK_DRIFT * passed)
        self._last = now
        if behind - self._least > LAG_LIMIT:
            raise HardwareError(
                f"the board's time stands still, runs slow or was set back: expected at most "
                f"{LAG_LIMIT * 1e3:.0f} ms behind the computer's"
            )
        self._set_back, self._kept = False, self._least
        return given + self._shift

    def _follow_restart(self, given: float, now: float) -> None:
        """Take the new origin of a clock that was set back, once it has kept step since then."""
        behind, is_back = now - given, given < self._given
        self._given = given
        self._set_back |= is_back
        if not self._set_back:
            return
        low, high = min(behind, self._low), max(behind, self._high)
        if is_back or high - low > LAG_LIMIT:
            low, high, self._since = behind, behind, now
        self._low, self._high = low, high
        if now - self._since >= RESTART_TIME:
            self._shift = low - self._kept
