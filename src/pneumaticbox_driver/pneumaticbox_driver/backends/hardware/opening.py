"""Opens the board of a hardware file: a box as in the thesis (Table 4.1) or a user's board."""

import importlib
import inspect
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from pneumaticbox_driver.arrays import Flags, Floats, Valves
from pneumaticbox_driver.backends.hardware.hardware_file import (
    Coil,
    LinuxHardware,
    OtherHardware,
    read_hardware,
)
from pneumaticbox_driver.backends.hardware.inputs import IioInputs
from pneumaticbox_driver.backends.hardware.lines import GpioLines, LinesError, OutputLines
from pneumaticbox_driver.backends.hardware.rig import HardwareRig, ValveBoard
from softhand_model.gas import AMBIENT_PRESSURE

MakeLines = Callable[[Sequence[Coil]], OutputLines]


class LinuxBoard:
    """Drives the coils of the outlets and reads the sensors; unused coils stay off.

    Coils are switched off first and on afterwards, so that the two coils of a valve are never on
    together. If some coils cannot be switched, as when their chip is gone, all others still are.

    Args:
        lines: the lines of all outlets of the box, inflate and deflate alternating.
        inputs: sensors of the channels, then of the supply.
        outlets: number of each channel's outlet, from 1 (n,).
    """

    def __init__(self, lines: OutputLines, inputs: IioInputs, outlets: Sequence[int]) -> None:
        self.inputs = inputs
        self._lines = lines
        self._first = 2 * (np.asarray(outlets) - 1)  # line of the inflating coil (n,)
        self._on: Flags = np.zeros(2 * len(outlets), dtype=bool)
        self._known = True  # whether the lines have the state `_on`

    def set_valves(self, valves: Valves) -> None:
        """Switch the coils to `valves` (n,); unchanged coils are not written again.

        Raises:
            LinesError: lines cannot be set. All others have been set, except coils that must not go
                on because the other coil of their valve does not go off.
        """
        valves = np.asarray(valves)
        wanted = np.concatenate([valves > 0, valves < 0])
        changed = (wanted != self._on) | (not self._known)
        self._known = False  # should switching fail in between: all are written again then
        errors: list[LinesError] = []
        for state in (False, True):
            lines = map(self._line, np.flatnonzero(changed & (wanted == state)).tolist())
            stuck = {line ^ 1 for error in errors for line in error.lines}  # their counterparts
            try:
                self._switch({line: state for line in lines if line not in stuck})
            except LinesError as error:
                errors.append(error)
        if errors:
            text = "; ".join(dict.fromkeys(str(error) for error in errors))
            raise LinesError(text, [line for error in errors for line in error.lines])
        self._on, self._known = wanted, True

    def _switch(self, active: dict[int, bool]) -> None:
        if active:
            self._lines.switch(active)

    def _line(self, coil: int) -> int:
        kind, channel = divmod(coil, len(self._first))
        return int(self._first[channel]) + kind

    def read(self) -> tuple[float, Floats]:
        """Read the monotonic time [s] and the absolute pressures (n + 1,) [Pa]."""
        return time.monotonic(), self.inputs.read()

    def close(self) -> None:
        """Release the lines and close the files."""
        try:
            self._lines.release()
        finally:
            self.inputs.close()


def open_rig(
    path: str | Path,
    outlets: Sequence[int],
    ambient: float = AMBIENT_PRESSURE,
    make_lines: MakeLines = GpioLines,
    allow_board_module: bool = False,
    needs_answer: bool = True,
) -> HardwareRig:
    """Open the box of a hardware file, valves closed.

    Args:
        path: path of the hardware file.
        outlets: number of each channel's outlet, from 1 (n,).
        ambient: absolute ambient pressure, as in the box's settings [Pa].
        make_lines: requests the GPIO lines of `board: linux`.
        allow_board_module: whether the file may name a user's board, whose Python module is run.
        needs_answer: whether a user's board has to answer; a class that does not take this keyword
            decides for itself.

    Raises:
        ValueError: the file cannot be used or lacks one of the outlets.
        HardwareError: (a ValueError) a device is missing or must not be used; no valve was switched
            and no device is held then.
    """
    hardware = read_hardware(path, allow_board_module)
    board = open_board(hardware, outlets, ambient, make_lines, needs_answer)
    return HardwareRig(board, len(outlets), hardware.vent_time)


def open_board(
    hardware: LinuxHardware | OtherHardware,
    outlets: Sequence[int],
    ambient: float = AMBIENT_PRESSURE,
    make_lines: MakeLines = GpioLines,
    needs_answer: bool = True,
) -> ValveBoard:
    """Open the board without a rig; arguments and errors are those of `open_rig`."""
    if isinstance(hardware, OtherHardware):
        return _other_board(hardware, outlets, ambient, needs_answer)
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


def _other_board(
    hardware: OtherHardware, outlets: Sequence[int], ambient: float, needs_answer: bool
) -> ValveBoard:
    make = _load_class(hardware)
    settings = {} if hardware.settings is None else hardware.settings.value
    keywords = {"outlets": tuple(outlets), "ambient": ambient, **settings}
    if not needs_answer and "needs_answer" in inspect.signature(make).parameters:
        keywords["needs_answer"] = False
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
        expected = "linux (GPIO and IIO of this computer) or the class of a board as module:Class"
        raise hardware.board.error(f"{expected}, which Python can import ({error})") from error
