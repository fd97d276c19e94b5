"""Command lines of benches: `--help` prints what the module says of itself."""

from __future__ import annotations

import argparse


def command_line(module: str, about: str | None) -> argparse.ArgumentParser:
    """A parser without options for `python -m module`; about: docstring of the module.

    >>> command_line("bench.hands", "Hidden effects.").format_usage()
    'usage: python -m bench.hands [-h]\\n'
    """
    return argparse.ArgumentParser(
        prog=f"python -m {module}",
        description=about,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )


def chosen_cases(module: str, about: str | None, cases: int) -> list[int]:
    """Numbers of the cases that the command line gives; all of so many if it gives none."""
    numbers: list[int] = with_cases(command_line(module, about), cases).numbers
    return numbers


def with_cases(parser: argparse.ArgumentParser, cases: int) -> argparse.Namespace:
    """What the command line gives, with the `numbers` of cases: all of so many if it gives none."""
    text = f"of a case, 0 to {cases - 1} (default: all)"
    parser.add_argument("numbers", nargs="*", type=int, metavar="NUMBER", help=text)
    given = parser.parse_args()
    given.numbers = given.numbers or list(range(cases))
    for number in given.numbers:
        if number not in range(cases):
            parser.error(f"NUMBER: expected 0 to {cases - 1}, got {number}")
    return given
