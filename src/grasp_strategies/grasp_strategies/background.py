"""Threads for work that blocks, beside an executor that must not."""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import TypeVar

Result = TypeVar("Result")


class Background:
    """Starts work in threads of its own and can wait for all of it."""

    def __init__(self) -> None:
        self._threads: list[threading.Thread] = []

    def start(
        self, work: Callable[[], Result], tell: Callable[[Result], None], on_error: Result
    ) -> None:
        """Begin `work`; `tell` is called in its thread with the result, or with `on_error`.

        An exception of `work` is not swallowed: the interpreter prints it, the caller is told.
        """

        def run() -> None:
            result = on_error
            try:
                result = work()
            finally:
                tell(result)

        self._threads = [thread for thread in self._threads if thread.is_alive()]
        self._threads.append(threading.Thread(target=run, name="strategy"))
        self._threads[-1].start()

    def join(self) -> None:
        """Wait until all work has ended."""
        for thread in self._threads:
            thread.join()
