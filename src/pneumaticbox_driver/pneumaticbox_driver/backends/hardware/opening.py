"""Opening of a real box: from a hardware file to its board and bench."""

import importlib
import inspect
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from pneumaticbox_driver.backends.hardware.bench import HardwareBench
from pneumaticbox_driver.backends.hardware.board import ValveBoard
from pneumaticbox_driver.backends.hardware.hardware_file import (
    Coil,
    LinuxHardware,
    OtherHardware,
    read_hardware,
)
from pneumaticbox_driver.backends.hardware.inputs import IioInputs
from pneumaticbox_driver.backends.hardware.lines import GpioLines, OutputLines
from pneumaticbox_driver.backends.hardware.linux_board import LinuxBoard
from softhand_model.gas import AMBIENT_PRESSURE

MakeLines = Callable[[Sequence[Coil]], OutputLines]


def open_bench(
    path: str | Path,
    outlets: Sequence[int],
    ambient: float = AMBIENT_PRESSURE,
    make_lines: MakeLines = GpioLines,
) -> HardwareBench:
    """Open the box of a hardware file, valves closed.

    Args:
        path: of the hardware file.
        outlets: number of each channel's outlet, from 1 (n,).
        ambient: absolute ambient pressure, that of the box's settings [Pa].
        make_lines: requests the GPIO lines of `board: linux`.

    Raises:
        ValueError: the file cannot be used, or outlets that it does not have.
        HardwareError: (a ValueError) a device is not there or may not be used; nothing has moved
            and nothing is held then.
    """
    hardware = read_hardware(path)
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
