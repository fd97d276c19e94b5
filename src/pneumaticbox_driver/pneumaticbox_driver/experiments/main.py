"""`pneumatics-experiment NAME`: simulate, report and plot one experiment of chapter 4.

Writes figure.png, result.json and series.npz into out/pneumatics/NAME, and a line of verdict.
Exit status: 0 done, whatever the verdict; 2 unusable input; 130 interrupted.
"""

import argparse
import sys
from collections.abc import Sequence
from dataclasses import fields
from pathlib import Path
from typing import Any

from pneumaticbox_driver.experiments import folder
from pneumaticbox_driver.experiments.catalogue import EXPERIMENTS, experiment
from pneumaticbox_driver.experiments.progress import ProgressLine

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
