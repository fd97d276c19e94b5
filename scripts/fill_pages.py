"""Fills pages of docs/ with what commands print: `python scripts/fill_pages.py docs/PAGE.md ...`.

A page holds, on lines of their own,

    <!-- printed by: python examples/stiff_actuator.py -->
    ...
    <!-- end -->

What stands between is replaced by the standard output of the command, run in the project's folder
by this interpreter. A command that fails leaves its part as it is; the exit status is then 1. One
that prints a verdict which falls short has not failed.
"""

from __future__ import annotations

import re
import shlex
import subprocess
import sys
from pathlib import Path

from softhand_common.documents.output_file import write_file

ROOT = Path(__file__).parents[1]
PART = re.compile(r"(<!-- printed by: (.+?) -->\n)(.*?)(<!-- end -->)", re.DOTALL)


def filled(text: str, printed: dict[str, str]) -> str:
    """A page with its parts replaced by what their commands have printed.

    >>> print(filled("a\\n<!-- printed by: x y -->\\nold\\n<!-- end -->\\n", {"x y": "new\\n"}))
    a
    <!-- printed by: x y -->
    <BLANKLINE>
    new
    <BLANKLINE>
    <!-- end -->
    <BLANKLINE>
    """

    def part(found: re.Match[str]) -> str:
        head, command, old, end = found.groups()
        return f"{head}\n{printed[command]}\n{end}" if command in printed else head + old + end

    return PART.sub(part, text)


def output_of(command: str) -> str | None:
    """What a command prints; None if it fails."""
    program, *words = shlex.split(command)
    interpreter = [sys.executable] if program == "python" else [sys.executable, "-m", program]
    print(f"running {command}", file=sys.stderr)
    done = subprocess.run([*interpreter, *words], cwd=ROOT, stdout=subprocess.PIPE, text=True)
    complete = done.returncode == 0 or "\nVerdict: falls short" in done.stdout
    return done.stdout if complete else None


def main(pages: list[str]) -> int:
    """Fill the pages; 1 if a command failed."""
    failed = False
    for page in map(Path, pages):
        text = page.read_text(encoding="utf-8")
        outputs = {command: output_of(command) for _, command, _, _ in PART.findall(text)}
        failed = failed or None in outputs.values()
        printed = {command: out for command, out in outputs.items() if out is not None}
        write_file(page, filled(text, printed))
    return int(failed)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
