"""A valve board for hardware files: bottles that run by the monotonic clock, until told to fail."""

import builtins
import time
from pathlib import Path

from pneumaticbox_driver.backends.embedded import EmbeddedBoard, EmbeddedRig


class FailingBoard:
    """Fails to read and to switch as long as the file `fault` exists: by OSError, by the error
    that is named in it, or, where it says `read blocks` or `set_valves blocks`, by not returning.

    The file `fault` with the suffix .told gets a line a call of `set_valves`: monotonic time [s]
    and valves.
    """

    def __init__(self, outlets, ambient, fault, volume):
        names = [f"outlet{number}" for number in outlets]
        self._board = EmbeddedBoard(EmbeddedRig(names, [volume] * len(names)))
        self._fault = Path(fault)
        self._told = self._fault.with_suffix(".told").open("a", buffering=1)

    def _check(self, call):
        while (fault := self._content()) is not None:
            if not fault.endswith("blocks"):
                raise getattr(builtins, fault or "OSError")("the board's cable is unplugged")
            if fault != f"{call} blocks":
                return
            time.sleep(0.01)

    def _content(self):
        try:
            return self._fault.read_text()
        except FileNotFoundError:
            return None

    def set_valves(self, valves):
        self._told.write(f"{time.monotonic()} {valves.tolist()}\n")
        self._check("set_valves")
        self._board.command(valves)

    def read(self):
        self._check("read")
        return time.monotonic(), self._board.read()

    def close(self):
        pass
