"""Progress of long work on the standard error: what it is at, and how far."""

from __future__ import annotations

import sys
from collections.abc import Callable
from typing import Any, TextIO

from tqdm import tqdm

PATIENCE = 2.0  # [s] before anything is shown
MOVE_EVERY = 1.0  # [s] between changes of a line that can be written over
LINE_EVERY = 15.0  # [s] between lines where none can


class Progress(tqdm):
    """A line that moves on a terminal, else a line now and then; a context.

    Call it with what is done now, its number and of how many (0: unknown), in words
    and numbers: `progress("fitting tube_lag", 7, 31)`.

    Args:
        what: what is done as a whole, such as `diagnosing`.
        stream: where it is shown, the standard error if None.
        patience: time [s] before anything is shown.
        unit: behind the numbers, such as ` %`.
    """

    monitor_interval = 0  # no thread of its own: processes are forked while it shows

    def __init__(
        self,
        what: str,
        stream: TextIO | None = None,
        patience: float = PATIENCE,
        unit: str = "",
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
        """Take what is done now."""
        place = f", {number} of {total}{self._unit}" if total else ""
        self.set_description_str(f"{self._what}: {step}{place}", refresh=False)
        self.update(0)

    def close(self) -> None:
        """Stop, and take a moving line away again."""
        if not self._moves:
            self.last_print_t = 0.0  # as if nothing had been shown: nothing is taken away
        super().close()

    @staticmethod
    def status_printer(file: Any) -> Callable[[str], None]:
        """How a line gets to the stream."""
        if file.isatty():
            return tqdm.status_printer(file)
        return lambda text: print(text, file=file, flush=True)
