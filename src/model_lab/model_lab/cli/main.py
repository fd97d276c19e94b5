"""`model-lab`: compare a model with measurements, learn what it lacks, add it, see the error fall.

Exit status: 0 done, whatever the verdict; 2 unusable input, with one line on the standard error
that names file, row or key, what was expected, what was found, and how to correct it; 70 a fault of
the lab; 74 standard output that cannot be written; 130 interrupted.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from textwrap import fill
from traceback import print_exception, walk_tb
from typing import NoReturn

from model_lab.cli.catalogue import COMMANDS
from softhand_common.documents.yaml_document import DocumentError
from softhand_common.standard_output import with_checked_output

PROGRAM = "model-lab"
HELP_WIDTH = 80  # of descriptions
DONE, UNUSABLE, FAULT, INTERRUPTED = 0, 2, 70, 130
PACKAGES = ("model_lab", "softhand_", "pneuflex_sim")


class _Parser(argparse.ArgumentParser):
    """A parser that reports a wrong argument in one line."""

    def error(self, message: str) -> NoReturn:
        self.exit(UNUSABLE, f"{self.prog}: {message}; {self.prog} --help tells more\n")


@with_checked_output(PROGRAM)
def main(arguments: Sequence[str] | None = None) -> int:
    """Run one command and return its exit status, as the module says. arguments: None: those of the
    command line.
    """
    parsed = make_parser().parse_args(arguments)
    try:
        COMMANDS[parsed.command].run(parsed)
    except ValueError as reason:
        if _is_of_input(reason):
            print(f"{PROGRAM}: {' '.join(str(reason).split())}", file=sys.stderr)
            return UNUSABLE
        print_exception(reason)
        print(f"{PROGRAM}: a fault of model-lab, not of your files: please report", file=sys.stderr)
        return FAULT
    except KeyboardInterrupt:
        print(f"{PROGRAM}: interrupted", file=sys.stderr)
        return INTERRUPTED
    except OSError as reason:
        wanted = "expected a file or folder that can be read or written"
        print(f"{PROGRAM}: {reason.filename}: {wanted}, got {reason.strerror}", file=sys.stderr)
        return UNUSABLE
    return DONE


def _is_of_input(reason: ValueError) -> bool:
    """Whether a file or an option was refused, by a package of this suite: an error of another
    library means that something was not checked before.
    """
    *_, (frame, _) = walk_tb(reason.__traceback__)
    raised_by = str(frame.f_globals.get("__name__", ""))
    return isinstance(reason, DocumentError) or raised_by.startswith(PACKAGES)


def make_parser() -> argparse.ArgumentParser:
    """The argument parser of `model-lab` with all its commands."""
    parser = _Parser(
        prog=PROGRAM,
        description="Compare a model with measurements, see where it fails, learn which physical "
        "effect is missing, add it, and watch the error fall.",
    )
    commands = parser.add_subparsers(dest="command", required=True, metavar="COMMAND")
    for name, command in COMMANDS.items():
        of_command = commands.add_parser(
            name,
            help=command.help,
            description=fill(command.description, HELP_WIDTH),
            epilog="\n".join(["examples:", *(f"  {line}" for line in command.examples)]),
            formatter_class=argparse.RawDescriptionHelpFormatter,
        )
        for flags, given in command.arguments:
            of_command.add_argument(*flags, **given)
    return parser


if __name__ == "__main__":
    sys.exit(main())
