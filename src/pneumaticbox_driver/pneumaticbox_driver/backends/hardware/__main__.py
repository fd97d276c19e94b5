"""First steps on a real box without the driver: read its sensors, pulse a coil, vent it."""

import argparse
import signal
import sys
import time
from collections.abc import Sequence

import numpy as np

from pneumaticbox_driver.arrays import Floats
from pneumaticbox_driver.backends.hardware.hardware_file import (
    ALLOW_BOARD_MODULE,
    HardwareError,
    LinuxHardware,
    OtherHardware,
    read_hardware,
)
from pneumaticbox_driver.backends.hardware.lines import GpioLines
from pneumaticbox_driver.backends.hardware.opening import (
    LinuxBoard,
    MakeLines,
    check_outlets,
    open_board,
    open_rig,
)
from pneumaticbox_driver.backends.hardware.rig import HardwareRig
from softhand_model.gas import AMBIENT_PRESSURE

PULSE_COMMAND_PERIOD = 0.005  # of commands during a pulse [s]
LONGEST_PULSE = 500.0  # [ms]
AFTER_PULSE = 0.2  # after a pulse [s]
VALVE_OF_DIRECTION = {"inflate": 1, "deflate": -1}
AVERAGED_READINGS = 100  # averaged by `read`


def main(arguments: Sequence[str] | None = None, make_lines: MakeLines = GpioLines) -> int:
    """Run an action of the command line; returns 0, or 2 after printing why it failed."""
    options = _parser().parse_args(arguments)
    try:
        {"read": _read, "pulse": _pulse, "vent": _vent}[options.action](options, make_lines)
    except (ValueError, OSError) as error:
        print(f"softhand hardware: {error}", file=sys.stderr)
        return 2
    return 0


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="softhand hardware", description=__doc__)
    parser.add_argument("file", help="hardware file")
    parser.add_argument(
        ALLOW_BOARD_MODULE,
        action="store_true",
        help="run the Python module that the file names as board; only for trusted files",
    )
    actions = parser.add_subparsers(dest="action", required=True)
    read = actions.add_parser("read", help="mean and spread of the sensors; every coil stays off")
    pulse = actions.add_parser("pulse", help="switch one coil on, then off, then vent the outlet")
    pulse.add_argument("outlet", type=int, help="number of the outlet, from 1")
    pulse.add_argument("direction", choices=VALVE_OF_DIRECTION)
    pulse.add_argument("duration", type=float, help=f"[ms], at most {LONGEST_PULSE:.0f}")
    vent = actions.add_parser("vent", help="open outlets for the file's vent_time")
    for action in (read, vent):
        action.add_argument("outlets", type=int, nargs="+", help="numbers of outlets, from 1")
    return parser


def _hardware(options: argparse.Namespace) -> LinuxHardware | OtherHardware:
    return read_hardware(options.file, options.allow_board_module)


def _read(options: argparse.Namespace, make_lines: MakeLines) -> None:
    board = open_board(_hardware(options), options.outlets, make_lines=make_lines)
    try:
        begun = time.monotonic()
        readings = np.array([board.read()[1] for _ in range(AVERAGED_READINGS)])
        spent = (time.monotonic() - begun) / AVERAGED_READINGS
        volts = board.inputs.volts() if isinstance(board, LinuxBoard) else None
    finally:
        board.close()
    names = [*(f"outlet {number}" for number in options.outlets), "supply"]
    for index, name in enumerate(names):
        shown = "" if volts is None else f"   {volts[index]:6.3f} V"
        print(f"{name:>9}: {_gauge(readings[:, index])}{shown}")
    print(f"a reading takes {spent * 1e3:.2f} ms; a control step has 2 ms")


def _gauge(readings: Floats) -> str:
    if not np.isfinite(readings).all():
        return "not readable, or a voltage outside of the sensor's output range"
    kilopascal = (readings - AMBIENT_PRESSURE) / 1e3
    return f"{kilopascal.mean():8.2f} kPa gauge, spread {kilopascal.std():.3f} kPa"


def _pulse(options: argparse.Namespace, make_lines: MakeLines) -> None:
    if not 0 < options.duration <= LONGEST_PULSE:
        raise ValueError(
            f"duration must be above 0 and at most {LONGEST_PULSE:g} ms, got {options.duration:g}"
        )
    allowed = options.allow_board_module
    with open_rig(
        options.file, [options.outlet], make_lines=make_lines, allow_board_module=allowed
    ) as rig:
        before = _sound(rig.read())
        _hold(rig, VALVE_OF_DIRECTION[options.direction], options.duration * 1e-3)
        _hold(rig, 0, AFTER_PULSE)
        after = _sound(rig.read())
    print(f"outlet {options.outlet}: {_gauge(before[:1])}, then {_gauge(after[:1])}")


def _hold(rig: HardwareRig, valve: int, duration: float) -> None:
    end = time.monotonic() + duration
    rig.command([valve])
    while time.monotonic() < end:
        time.sleep(min(PULSE_COMMAND_PERIOD, max(0.0, end - time.monotonic())))
        _sound(rig.read())
        rig.command([valve])


def _sound(pressures: Floats) -> Floats:
    """Return the pressures; raises HardwareError if one of them could not be read."""
    if not np.isfinite(pressures).all():
        bad = ("outlet", "supply")[int(np.argmin(np.isfinite(pressures)))]
        raise HardwareError(
            f"sensor of the {bad}: expected a pressure, got none; all outlets were opened"
        )
    return pressures


def _vent(options: argparse.Namespace, make_lines: MakeLines) -> None:
    hardware = _hardware(options)
    if isinstance(hardware, OtherHardware):
        open_rig(options.file, options.outlets, allow_board_module=True, needs_answer=False).close()
        return
    # without the sensors, which may be the reason for the vent
    check_outlets(options.outlets, len(hardware.outlets))
    lines = make_lines(hardware.coils)
    try:
        try:
            lines.switch({2 * number - 1: True for number in options.outlets})
        finally:  # if a chip is gone, the outlets of the others are open
            time.sleep(hardware.vent_time)
    finally:
        lines.release()


if __name__ == "__main__":
    for number in (signal.SIGTERM, signal.SIGHUP):
        signal.signal(number, lambda *_: sys.exit(1))  # runs the exit handler: the outlets open
    # a shell script starts background processes with SIGINT ignored
    signal.signal(signal.SIGINT, signal.default_int_handler)
    sys.exit(main())
