"""The standard output of a command: where it cannot be written, that is said in one line."""

from __future__ import annotations

import os
import sys
from collections.abc import Callable
from functools import wraps
from typing import Any, ParamSpec, TextIO, cast

DONE, LOST = 0, 74  # exit statuses; EX_IOERR of sysexits.h

P = ParamSpec("P")


class OutputLost(Exception):
    """The standard output cannot be written.

    Not an OSError, since commands report an OSError as an error of a file that they read or write.
    """

    def __init__(self, reason: OSError) -> None:
        super().__init__(f"standard output: expected a place to write to, got {reason.strerror}")
        self.is_closed = isinstance(reason, BrokenPipeError)


class _Output:
    """A stream whose errors are OutputLost."""

    def __init__(self, stream: TextIO) -> None:
        self._stream = stream

    def __getattr__(self, name: str) -> Any:
        return getattr(self._stream, name)

    def write(self, text: str) -> int:
        try:
            return self._stream.write(text)
        except OSError as reason:
            raise OutputLost(reason) from reason

    def flush(self) -> None:
        try:
            self._stream.flush()
        except OSError as reason:
            raise OutputLost(reason) from reason


def with_checked_output(program: str) -> Callable[[Callable[P, int]], Callable[P, int]]:
    """Decorate the function of a command, which returns its exit status.

    When its standard output cannot be written, as on a full disk, it ends with status 74 and one
    line on the standard error that begins with `program`. When the program that reads the output
    has ended, such as `head`, it ends with status 0 and prints nothing.
    """

    def decorate(main: Callable[P, int]) -> Callable[P, int]:
        @wraps(main)
        def run(*given: P.args, **named: P.kwargs) -> int:
            stream = sys.stdout
            if stream is None:  # closed from the start: print does nothing
                return main(*given, **named)
            sys.stdout = cast(TextIO, _Output(stream))
            try:
                try:
                    return main(*given, **named)
                finally:
                    sys.stdout.flush()
            except OutputLost as lost:
                # what is left would be tried again when the process ends
                os.dup2(os.open(os.devnull, os.O_WRONLY), stream.fileno())
                if lost.is_closed:
                    return DONE
                print(f"{program}: {lost}", file=sys.stderr)
                return LOST
            finally:
                sys.stdout = stream

        return run

    return decorate
