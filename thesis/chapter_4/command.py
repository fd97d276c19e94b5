"""`pneumatics-experiment NAME`: simulate, report and plot one experiment of chapter 4.

Progress of an experiment on standard error.

`pneumatics-experiment NAME`: simulate, report and plot one experiment of chapter 4.

Writes figure.png, result.json and series.npz into out/pneumatics/NAME, and a line of verdict.
Exit status: 0 done, whatever the verdict; 2 unusable input; 130 interrupted.
"""

import argparse
import importlib
import sys
import time
from collections.abc import Sequence
from dataclasses import fields
from pathlib import Path
from types import ModuleType, TracebackType
from typing import Any

from thesis.chapter_4 import report as folder

EXPERIMENTS = (
    "pulse_error",
    "supply_rejection",
    "six_channels",
    "long_run",
    "finger_posture",
    "drift_pulses",
    "choke_size",
    "valve_speed",
    "dead_volume",
    "scheduled_events",
    "flow_function",
)


def experiment(name: str) -> ModuleType:
    """Return the module of an experiment.

    Raises:
        ValueError: no such experiment; the message lists them.
    """
    if name not in EXPERIMENTS:
        raise ValueError(f"experiment: expected one of {', '.join(EXPERIMENTS)}, got {name}")
    return importlib.import_module(f"thesis.chapter_4.{name}")


INTERVAL = 1.0  # between lines on a terminal [s]
IN_A_LOG = 15.0  # between lines elsewhere [s]


class ProgressLine:
    """One line that moves on a terminal; in a log, a line every 15 s."""

    def __init__(self, name: str) -> None:
        self._name = name
        self._moving = sys.stderr.isatty()
        self._last = time.monotonic() if not self._moving else 0.0

    def __enter__(self) -> "ProgressLine":
        return self

    def __call__(self, what: str, share: float) -> None:
        """Say what is going on, and which share of it is done [-]."""
        now = time.monotonic()
        if now - self._last < (INTERVAL if self._moving else IN_A_LOG):
            return
        self._last = now
        head, tail = ("\r\033[K", "") if self._moving else ("", "\n")
        line = f"{head}{self._name}: {what}, {100 * share:.0f} %{tail}"
        print(line, end="", file=sys.stderr, flush=True)

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        if self._moving:
            print("\r\033[K", end="", file=sys.stderr, flush=True)


PROGRAM = "pneumatics-experiment"
OUT = Path("out/pneumatics")


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one command; see the module for the exit status."""
    given = make_parser().parse_args(arguments)
    try:
        if given.experiment == "list":
            print("\n".join(f"{name:18s} {experiment(name).SENTENCE}" for name in EXPERIMENTS))
        elif given.experiment == "all":
            for name in EXPERIMENTS:
                force = ["--force"] if given.force else []
                run(make_parser().parse_args([name, "--seed", str(given.seed), *force]))
        else:
            run(given)
    except (ValueError, OSError) as reason:
        print(f"{PROGRAM}: {reason}", file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        print(f"{PROGRAM}: interrupted", file=sys.stderr)
        return 130
    return 0


def make_parser() -> argparse.ArgumentParser:
    """The parser of all experiments; each has its settings as options."""
    parser = argparse.ArgumentParser(
        prog=PROGRAM, description="Run an experiment of chapter 4 on the pretended bench."
    )
    commands = parser.add_subparsers(dest="experiment", required=True, metavar="NAME")
    commands.add_parser("list", help="list the experiments, with a sentence each")
    everything = commands.add_parser("all", help="run all of them as they stand, a few minutes")
    _add_common(everything)
    for name in EXPERIMENTS:
        module = experiment(name)
        one = commands.add_parser(name, help=module.SENTENCE, description=_description(module))
        _add_common(one)
        one.add_argument("--out", type=Path, default=OUT / name, help=f"folder ({OUT / name})")
        one.add_argument("--redraw", action="store_true", help="report and plot kept series anew")
        for setting in fields(module.Settings):
            _add_setting(one, setting.name, setting.default, setting.metadata["help"])
    return parser


def _description(module: Any) -> str:
    return f"{module.SENTENCE} Thesis: {module.THESIS}."


def _add_common(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--seed", type=int, default=0, help="number of the box, and of its noise")
    parser.add_argument("--force", action="store_true", help="overwrite what is there")


def _add_setting(parser: argparse.ArgumentParser, name: str, default: Any, help: str) -> None:
    many = isinstance(default, tuple)
    shown = " ".join(f"{value:g}" for value in default) if many else f"{default:g}"
    parser.add_argument(
        f"--{name.replace('_', '-')}",
        type=type(default[0] if many else default),
        nargs="+" if many else None,
        default=default,
        metavar="X" if isinstance(default, float) or many else "N",
        help=f"{help} (default: {shown})",
    )


def run(given: argparse.Namespace) -> None:
    """Simulate, or take kept series; report and plot them, write all, print the verdict.

    Raises:
        ValueError: unusable settings, or there is something already and no --force.
    """
    module = experiment(given.experiment)
    place = folder.ResultFolder(given.out)
    if given.redraw:
        kept, series = place.read()
        seed, settings = kept["seed"], module.Settings(**_tuples(kept["settings"]))
    else:
        place.check_free(given.force)
        named = {field.name: getattr(given, field.name) for field in fields(module.Settings)}
        seed, settings = given.seed, module.Settings(**_tuples(named))
        with ProgressLine(given.experiment) as progress:
            series = module.simulate(settings, seed, progress)
    report = module.report(series, settings)
    place.write(given.experiment, settings, seed, report, series)
    place.draw(module, series, report)
    print(f"{given.experiment}: {report.verdict}")


def _tuples(settings: dict[str, Any]) -> dict[str, Any]:
    return {name: tuple(v) if isinstance(v, list) else v for name, v in settings.items()}
