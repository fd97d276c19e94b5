"""Progress on the standard error, for whatever takes longer than two seconds."""

from __future__ import annotations

import sys
import time
from threading import Event, Lock, Thread
from types import TracebackType
from typing import TextIO

PATIENCE = 2.0  # [s] before anything is shown
LINE_EVERY = 5.0  # [s] between lines where none can be written over
MOVE_EVERY = 0.2  # [s] between changes of one that can


class Progress:
    """A sign of life: one line that moves on a terminal, else a line every few seconds; a context.

    It shows by itself, also while nothing is told. Call it with the part that is done, from 0 to 1,
    and what is done now.

    Args:
        what: what is done, such as `reading the measurements`.
        stream: where it is shown, the standard error if None.
        patience: time [s] before anything is shown.
    """

    def __init__(self, what: str, stream: TextIO | None = None, patience: float = PATIENCE) -> None:
        self._what, self._patience = what, patience
        self._stream = sys.stderr if stream is None else stream
        self._moves = self._stream.isatty()
        self._part: float | None = None
        self._step = ""
        self._width = 0
        self._ended = Event()
        self._lock = Lock()
        self._start = time.monotonic()

    def __call__(self, part: float, step: str = "") -> None:
        """Tell the part that is done and what is done now."""
        with self._lock:
            self._part, self._step = part, step

    def __enter__(self) -> Progress:
        self._start = time.monotonic()
        self._thread = Thread(target=self._show_until_ended, daemon=True)
        self._thread.start()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        """Stop, and take a moving line away again."""
        self._ended.set()
        self._thread.join()
        if self._width:
            self._stream.write("\r" + " " * self._width + "\r")
            self._stream.flush()

    def _show_until_ended(self) -> None:
        pause = self._patience
        while not self._ended.wait(pause):
            self._show()
            pause = MOVE_EVERY if self._moves else LINE_EVERY

    def _show(self) -> None:
        line = self._line()
        if self._moves:
            self._stream.write("\r" + line.ljust(self._width))
            self._width = len(line)
        else:
            self._stream.write(line + "\n")
        self._stream.flush()

    def _line(self) -> str:
        with self._lock:
            part, step = self._part, self._step
        shown = f" {100.0 * part:.0f} %," if part else ""
        detail = f", {step}" if step else ""
        return f"{self._what}:{shown} {time.monotonic() - self._start:.0f} s{detail}"
