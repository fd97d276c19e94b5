"""First steps on a real box without the driver: read its sensors, pulse a coil, vent it."""

import argparse
import signal
import sys
import time
from collections.abc import Sequence

import numpy as np

from pneumaticbox_driver.arrays import Floats
from pneumaticbox_driver.backends.hardware.bench import HardwareBench
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
    open_bench,
    open_board,
)
from softhand_model.gas import AMBIENT_PRESSURE

PERIOD = 0.005  # of commands during a pulse [s]
LONGEST_PULSE = 500.0  # [ms]
SETTLING = 0.2  # after a pulse [s]
DIRECTIONS = {"inflate": 1, "deflate": -1}
SAMPLES = 100  # averaged by `read`


def main(arguments: Sequence[str] | None = None, make_lines: MakeLines = GpioLines) -> int:
    """Do what the command line asks for; 0, or 2 when it cannot be done, with the reason."""
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
        help="run the Python module that the file names as board; only for files that you trust",
    )
    actions = parser.add_subparsers(dest="action", required=True)
    read = actions.add_parser("read", help="mean and spread of the sensors; every coil stays off")
    pulse = actions.add_parser("pulse", help="switch one coil on, then off, then vent the outlet")
    pulse.add_argument("outlet", type=int, help="from 1")
    pulse.add_argument("direction", choices=DIRECTIONS)
    pulse.add_argument("duration", type=float, help=f"[ms], at most {LONGEST_PULSE:.0f}")
    vent = actions.add_parser("vent", help="open outlets for the file's vent_time")
    for action in (read, vent):
        action.add_argument("outlets", type=int, nargs="+", help="numbers, from 1")
    return parser


def _hardware(options: argparse.Namespace) -> LinuxHardware | OtherHardware:
    return read_hardware(options.file, options.allow_board_module)


def _read(options: argparse.Namespace, make_lines: MakeLines) -> None:
    board = open_board(_hardware(options), options.outlets, make_lines=make_lines)
    try:
        begun = time.monotonic()
        readings = np.array([board.read()[1] for _ in range(SAMPLES)])
        spent = (time.monotonic() - begun) / SAMPLES
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
        return "not readable, or a voltage that a sound sensor does not give"
    kilopascal = (readings - AMBIENT_PRESSURE) / 1e3
    return f"{kilopascal.mean():8.2f} kPa gauge, spread {kilopascal.std():.3f} kPa"


def _pulse(options: argparse.Namespace, make_lines: MakeLines) -> None:
    if not 0 < options.duration <= LONGEST_PULSE:
        raise ValueError(
            f"duration must be above 0 and at most {LONGEST_PULSE:g} ms, got {options.duration:g}"
        )
    allowed = options.allow_board_module
    with open_bench(
        options.file, [options.outlet], make_lines=make_lines, allow_board_module=allowed
    ) as bench:
        before = _sound(bench.read())
        _hold(bench, DIRECTIONS[options.direction], options.duration * 1e-3)
        _hold(bench, 0, SETTLING)
        after = _sound(bench.read())
    print(f"outlet {options.outlet}: {_gauge(before[:1])}, then {_gauge(after[:1])}")


def _hold(bench: HardwareBench, valve: int, duration: float) -> None:
    end = time.monotonic() + duration
    bench.command([valve])
    while time.monotonic() < end:
        time.sleep(min(PERIOD, max(0.0, end - time.monotonic())))
        _sound(bench.read())
        bench.command([valve])


def _sound(pressures: Floats) -> Floats:
    """Return the pressures; raises HardwareError when there is one that could not be read."""
    if not np.isfinite(pressures).all():
        bad = ("outlet", "supply")[int(np.argmin(np.isfinite(pressures)))]
        raise HardwareError(f"sensor of the {bad}: expected a pressure, got none; vented")
    return pressures


def _vent(options: argparse.Namespace, make_lines: MakeLines) -> None:
    hardware = _hardware(options)
    if isinstance(hardware, OtherHardware):
        open_bench(options.file, options.outlets, allow_board_module=True).close()
        return
    # without the sensors: they may be the reason
    check_outlets(options.outlets, len(hardware.outlets))
    lines = make_lines(hardware.coils)
    try:
        lines.switch({2 * number - 1: True for number in options.outlets})
        time.sleep(hardware.vent_time)
    finally:
        lines.release()


if __name__ == "__main__":
    for number in (signal.SIGTERM, signal.SIGHUP):
        signal.signal(number, lambda *_: sys.exit(1))  # an end by which the outlets open
    # begun in the background by a shell script, it would ignore Ctrl-C
    signal.signal(signal.SIGINT, signal.default_int_handler)
    sys.exit(main())
