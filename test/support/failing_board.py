"""A valve board for hardware files: bottles that run by the monotonic clock, until told to fail."""

import builtins
import time
from pathlib import Path

from pneumaticbox_driver.backends.embedded import EmbeddedBench, EmbeddedBoard


class FailingBoard:
    """Fails to read and to switch as long as the file `fault` exists: by OSError, or by the error
    that is named in it.
    """

    def __init__(self, outlets, ambient, fault, volume):
        names = [f"outlet{number}" for number in outlets]
        self._board = EmbeddedBoard(EmbeddedBench(names, [volume] * len(names)))
        self._fault = Path(fault)

    def _check(self):
        if self._fault.exists():
            error = getattr(builtins, self._fault.read_text() or "OSError")
            raise error("the board's cable is unplugged")

    def set_valves(self, valves):
        self._check()
        self._board.command(valves)

    def read(self):
        self._check()
        return time.monotonic(), self._board.read()

    def close(self):
        pass
