"""The thesis's kind of box (Table 4.1), and how a hardware file opens it or another board."""

import importlib
import inspect
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from pneumaticbox_driver.arrays import Flags, Floats, Valves
from pneumaticbox_driver.backends.hardware.bench import HardwareBench, ValveBoard
from pneumaticbox_driver.backends.hardware.hardware_file import (
    Coil,
    LinuxHardware,
    OtherHardware,
    read_hardware,
)
from pneumaticbox_driver.backends.hardware.inputs import IioInputs
from pneumaticbox_driver.backends.hardware.lines import GpioLines, OutputLines
from softhand_model.gas import AMBIENT_PRESSURE

MakeLines = Callable[[Sequence[Coil]], OutputLines]


class LinuxBoard:
    """Drives the outlets' coils and reads the sensors; coils not in use stay off.

    Coils that go off are switched before coils that go on, so never both of a valve are on.

    Args:
        lines: of all outlets of the box, inflate and deflate in turn.
        inputs: sensors of the channels, then of the supply.
        outlets: number of each channel's outlet, from 1 (n,).
    """

    def __init__(self, lines: OutputLines, inputs: IioInputs, outlets: Sequence[int]) -> None:
        self.inputs = inputs
        self._lines = lines
        self._first = 2 * (np.asarray(outlets) - 1)  # line of the inflating coil (n,)
        self._on: Flags = np.zeros(2 * len(outlets), dtype=bool)
        self._known = True  # whether `_on` is what the lines carry

    def set_valves(self, valves: Valves) -> None:
        """Switch the coils to `valves` (n,); what is as it was is not written again.

        Raises:
            HardwareError: a line cannot be set.
        """
        valves = np.asarray(valves)
        wanted = np.concatenate([valves > 0, valves < 0])
        changed = (wanted != self._on) | (not self._known)
        self._known = False  # should switching fail in between: all are written again then
        for state in (False, True):
            coils = np.flatnonzero(changed & (wanted == state)).tolist()
            if coils:
                self._lines.switch({self._line(coil): state for coil in coils})
        self._on, self._known = wanted, True

    def _line(self, coil: int) -> int:
        kind, channel = divmod(coil, len(self._first))
        return int(self._first[channel]) + kind

    def read(self) -> tuple[float, Floats]:
        """Read the monotonic time [s] and the absolute pressures then (n + 1,) [Pa]."""
        return time.monotonic(), self.inputs.read()

    def close(self) -> None:
        """Give lines and files back."""
        try:
            self._lines.release()
        finally:
            self.inputs.close()


def open_bench(
    path: str | Path,
    outlets: Sequence[int],
    ambient: float = AMBIENT_PRESSURE,
    make_lines: MakeLines = GpioLines,
    allow_board_module: bool = False,
) -> HardwareBench:
    """Open the box of a hardware file, valves closed.

    Args:
        path: of the hardware file.
        outlets: number of each channel's outlet, from 1 (n,).
        ambient: absolute ambient pressure, that of the box's settings [Pa].
        make_lines: requests the GPIO lines of `board: linux`.
        allow_board_module: whether the file may name a board of the user's own, Python code.

    Raises:
        ValueError: the file cannot be used, or outlets that it does not have.
        HardwareError: (a ValueError) a device is not there or may not be used; nothing has moved
            and nothing is held then.
    """
    hardware = read_hardware(path, allow_board_module)
    board = open_board(hardware, outlets, ambient, make_lines)
    return HardwareBench(board, len(outlets), hardware.vent_time)


def open_board(
    hardware: LinuxHardware | OtherHardware,
    outlets: Sequence[int],
    ambient: float = AMBIENT_PRESSURE,
    make_lines: MakeLines = GpioLines,
) -> ValveBoard:
    """Open the board alone; arguments and errors as those of `open_bench`."""
    if isinstance(hardware, OtherHardware):
        return _other_board(hardware, outlets, ambient)
    check_outlets(outlets, len(hardware.outlets))
    sensors = [hardware.outlets[number - 1].sensor for number in outlets]
    inputs = IioInputs(hardware.converter, [*sensors, hardware.supply], ambient)
    try:
        lines = make_lines(hardware.coils)
    except BaseException:
        inputs.close()
        raise
    return LinuxBoard(lines, inputs, outlets)


def check_outlets(outlets: Sequence[int], there: int) -> None:
    """Raise ValueError unless `outlets` are different numbers of a box with `there` outlets."""
    known = all(1 <= number <= there for number in outlets)
    if not known or not outlets or len(set(outlets)) < len(outlets):
        expected = f"different numbers from 1 to {there}"
        raise ValueError(f"outlets must be {expected}, got {list(outlets)}")


def _other_board(hardware: OtherHardware, outlets: Sequence[int], ambient: float) -> ValveBoard:
    make = _load_class(hardware)
    settings = {} if hardware.settings is None else hardware.settings.value
    keywords = {"outlets": tuple(outlets), "ambient": ambient, **settings}
    try:
        inspect.signature(make).bind(**keywords)
    except TypeError as error:
        node = hardware.settings or hardware.board
        raise node.error(f"settings that {hardware.board.value} takes ({error})") from error
    board: ValveBoard = make(**keywords)
    return board


def _load_class(hardware: OtherHardware) -> Any:
    module, _, name = hardware.board.text().partition(":")
    try:
        return getattr(importlib.import_module(module), name)
    except (ImportError, AttributeError, ValueError) as error:
        raise hardware.board.error(f"linux or an importable module:Class ({error})") from error
