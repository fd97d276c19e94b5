"""`python -m thesis`: lists, runs and draws the thesis's experiments.

Exit status: 0 done, and every target is met that there is; 1 a target is missed, or a run failed;
2 unusable input; 130 interrupted.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import fields
from functools import partial
from pathlib import Path
from types import ModuleType
from typing import Any, NoReturn

from softhand_common.progress import Progress
from thesis import frame

OUT = Path("out/thesis")
FORCE = "replace an earlier result; single simulations stored beside it are not run again"


class _Parser(argparse.ArgumentParser):
    """A parser that reports a wrong argument in one line."""

    def error(self, message: str) -> NoReturn:
        self.exit(2, f"{self.prog}: {message}; {self.prog} --help tells more\n")


def main(arguments: Sequence[str] | None = None) -> int:
    """List, run one, or run all; see the module for the exit status."""
    options = parser().parse_args(_with_run(sys.argv[1:] if arguments is None else arguments))
    try:
        return _status(lambda: options.act(options))
    except KeyboardInterrupt:
        print("thesis: interrupted", file=sys.stderr)
        return 130


def _status(act: Callable[[], int]) -> int:
    """Exit status of a call; a refusal or failure is printed in one line."""
    try:
        return act()
    except (ValueError, OSError) as reason:
        print(f"thesis: {reason}", file=sys.stderr)
        return 2
    except RuntimeError as reason:
        print(f"thesis: {reason}", file=sys.stderr)
        return 1


def _with_run(words: Sequence[str]) -> Sequence[str]:
    """`NAME ...` as short for `run NAME ...`."""
    names = [found.name for folder in frame.chapters() for found in frame.entries(folder)]
    return ["run", *words] if words and words[0] in names else words


def parser() -> argparse.ArgumentParser:
    """The command line; `run NAME --help` lists the parameters of an experiment."""
    found = _Parser(
        prog="python -m thesis",
        description="Make experiments of the thesis again.",
        epilog="Exit status: 0 when every target is met, or there is none; 1 when one is missed or "
        "a run failed; 2 for unusable input; 130 when interrupted.",
    )
    commands = found.add_subparsers(required=True, metavar="COMMAND")
    listing = commands.add_parser("list", help="list the experiments, with a line each")
    listing.set_defaults(act=_list)
    one = commands.add_parser("run", help="run an experiment, or draw an earlier run again")
    one.add_argument("name", help="of the experiment; `run NAME --help` tells its parameters")
    rest = one.add_argument("options", nargs=argparse.REMAINDER, help=argparse.SUPPRESS)
    rest.required = False
    one.set_defaults(act=lambda options: _run(frame.experiment(options.name), options.options))
    every = commands.add_parser("all", help="run all experiments, or those of one chapter")
    every.add_argument("chapter", nargs="?", choices=frame.chapters(), help="its folder")
    every.add_argument("--seed", type=int, metavar="N", help="of those that draw random numbers")
    every.add_argument("--out", type=Path, default=OUT, help=f"folder of all results ({OUT})")
    every.add_argument("--small", action="store_true", help="with parameters that take seconds")
    every.add_argument("--force", action="store_true", help=FORCE)
    every.set_defaults(act=_all)
    return found


def parser_of(module: ModuleType) -> argparse.ArgumentParser:
    """The options of one experiment, its parameters among them."""
    name = frame.name_of(module)
    one = _Parser(
        prog=f"python -m thesis run {name}",
        description=f"{module.__doc__}\n\nThe result ({frame.RESULT}, {frame.FIGURE}, arrays in "
        f"{frame.SERIES}) goes to a folder; table and verdict are printed.",
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    one.add_argument("--out", type=Path, default=OUT / name, help=f"folder ({OUT / name})")
    one.add_argument("--force", action="store_true", help=FORCE)
    one.add_argument("--redraw", action="store_true", help="report and draw an earlier run again")
    one.add_argument("--figure", type=Path, help="draw another copy of the figure here (PNG)")
    one.add_argument("--small", action="store_true", help="with parameters that take seconds")
    own = one.add_argument_group("parameters")
    for entry in fields(frame.parameters_of(module)):
        _add_parameter(own, entry.name, entry.default, entry.metadata["help"])
    return one


def _add_parameter(group: Any, name: str, default: Any, help: str) -> None:
    many = isinstance(default, tuple)
    values = default if many else (default,)
    kind = type(values[0])
    shown = " ".join(f"{value:g}" if kind is float else str(value) for value in values)
    group.add_argument(
        f"--{name.replace('_', '-')}",
        type=kind,
        nargs="*" if many else None,
        default=argparse.SUPPRESS,
        metavar={float: "X", int: "N"}.get(kind, "NAME"),
        help=f"{help.replace('%', '%%')} (default: {shown})",
    )


def _list(options: argparse.Namespace) -> int:
    found = frame.experiments()
    print("\n".join(f"{name:18s} {frame.title_of(module)}" for name, module in found.items()))
    return 0


def _all(options: argparse.Namespace) -> int:
    statuses = [0]
    for name, module in frame.experiments(options.chapter).items():
        if options.small and getattr(module, "SMALL", {}) is None:
            print(f"{name}: left out, it has no small run", file=sys.stderr)
            continue
        words = ["--out", str(options.out / name)]
        words += [f"--{word}" for word in ("small", "force") if getattr(options, word)]
        if options.seed is not None and hasattr(frame.parameters_of(module), "seed"):
            words += ["--seed", str(options.seed)]
        print(f"## {name}\n")
        statuses.append(_status(partial(_run, module, words)))
        print(flush=True)
    return max(statuses)


def _run(module: ModuleType, words: Sequence[str]) -> int:
    """Run an experiment, or take an earlier run; report and draw it. 1 if a target is missed."""
    options, name = parser_of(module).parse_args(words), frame.name_of(module)
    if options.redraw:
        parameters, results = frame.read_result(options.out, module)
    else:
        parameters = frame.parameters_of(module, _given(module, options))
        if hasattr(parameters, "continued"):
            parameters = parameters.continued(options.out)
        elif not options.force:
            frame.check_free(options.out)
        with progress_line(name) as progress:
            results = module.run(parameters, frame.Job(options.out, progress))
    report = module.report(results, parameters)
    frame.write_result(options.out, module, parameters, results, report)
    print(f"{report.table}\n\nVerdict: {report.verdict}")
    for path in [options.out / frame.FIGURE, *([options.figure] if options.figure else [])]:
        frame.save_figure(module, results, report, path)
    print(f"{name}: written to {options.out}", file=sys.stderr)
    return int(not all(report.judged))


def _given(module: ModuleType, options: argparse.Namespace) -> dict[str, Any]:
    small = getattr(module, "SMALL", {}) if options.small else {}
    if small is None:
        raise ValueError(f"{frame.name_of(module)}: has no small run")
    names = [entry.name for entry in fields(frame.parameters_of(module))]
    return small | {name: getattr(options, name) for name in names if hasattr(options, name)}


@contextmanager
def progress_line(name: str) -> Iterator[frame.Progress]:
    """Shows the current activity and the share done: once a second on a terminal, rarely in a
    log.
    """
    with Progress(name) as line:
        yield lambda what, share: line(f"{what}, {100.0 * share:.0f} %", 0, 0)


if __name__ == "__main__":
    sys.exit(main())
