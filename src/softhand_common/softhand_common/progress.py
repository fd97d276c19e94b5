"""Progress of a long computation, shown on the standard error."""

from __future__ import annotations

import sys
from collections.abc import Callable
from typing import Any, TextIO

from tqdm import tqdm

SILENT_TIME = 2.0  # [s] before anything is shown
MOVE_EVERY = 1.0  # [s] between updates of the line on a terminal
LINE_EVERY = 15.0  # [s] between lines elsewhere, where none can be written over


class Progress(tqdm):
    """Progress of a computation: on a terminal one line that is updated, else a new line every
    LINE_EVERY [s]. A context manager.

    Call it with the name of the current step, its number, and the number of all steps (0: unknown):
    `progress("fitting tube_lag", 7, 31)`.

    Args:
        what: name of the whole computation, such as `diagnosing`.
        stream: stream to which it is written; None: the standard error.
        patience: time [s] before anything is shown.
        unit: text behind the numbers, such as ` %`.
    """

    monitor_interval = 0  # tqdm starts no thread: processes are forked in the meantime

    def __init__(
        self, what: str, stream: TextIO | None = None, patience: float = SILENT_TIME, unit: str = ""
    ) -> None:
        shown = stream or sys.stderr
        self._what, self._unit, self._moves = what, unit, shown.isatty()
        super().__init__(
            desc=what,
            file=shown,
            delay=patience,
            leave=False,
            miniters=0,
            mininterval=MOVE_EVERY if self._moves else LINE_EVERY,
            bar_format="{desc} ({elapsed})",
        )

    def __call__(self, step: str, number: int, total: int) -> None:
        """Set the current step, its number and the number of steps (0: unknown)."""
        place = f", {number} of {total}{self._unit}" if total else ""
        self.set_description_str(f"{self._what}: {step}{place}", refresh=False)
        self.update(0)

    def say(self, line: str) -> None:
        """Print a line that stays, above the line of progress."""
        self.write(line, file=self.fp)
        self.fp.flush()

    def close(self) -> None:
        """End the display; on a terminal its line is removed."""
        if not self._moves:
            self.last_print_t = 0.0  # as if nothing had been shown, so tqdm removes nothing
        super().close()

    def moveto(self, n: int) -> None:
        """Move the cursor to a line of progress within another; elsewhere lines are only added."""
        if self._moves:
            super().moveto(n)

    @staticmethod
    def status_printer(file: Any) -> Callable[[str], None]:
        """The function that writes a line to a stream."""
        if file.isatty():
            return tqdm.status_printer(file)
        return lambda text: print(text, file=file, flush=True)
