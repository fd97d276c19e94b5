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
    parser = command_line(module, about)
    text = f"of a case, 0 to {cases - 1} (default: all)"
    parser.add_argument("numbers", nargs="*", type=int, metavar="NUMBER", help=text)
    numbers: list[int] = parser.parse_args().numbers or list(range(cases))
    for number in numbers:
        if number not in range(cases):
            parser.error(f"NUMBER: expected 0 to {cases - 1}, got {number}")
    return numbers
