"""Progress of an experiment on standard error."""

import sys
import time
from types import TracebackType

INTERVAL = 1.0  # between lines on a terminal [s]
IN_A_LOG = 15.0  # between lines elsewhere [s]


class ProgressLine:
    """One line that moves on a terminal; in a log, a line every 15 s."""

    def __init__(self, name: str) -> None:
        self._name = name
        self._moving = sys.stderr.isatty()
        self._last = time.monotonic() if not self._moving else 0.0

    def __enter__(self) -> "ProgressLine":
        return self

    def __call__(self, what: str, share: float) -> None:
        """Say what is going on, and which share of it is done [-]."""
        now = time.monotonic()
        if now - self._last < (INTERVAL if self._moving else IN_A_LOG):
            return
        self._last = now
        head, tail = ("\r\033[K", "") if self._moving else ("", "\n")
        line = f"{head}{self._name}: {what}, {100 * share:.0f} %{tail}"
        print(line, end="", file=sys.stderr, flush=True)

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        if self._moving:
            print("\r\033[K", end="", file=sys.stderr, flush=True)
