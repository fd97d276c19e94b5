"""Writes docs/reference/errata.md: every ERRATUM that a docstring names (`make docs`)."""

from __future__ import annotations

import ast
import inspect
import re
from collections.abc import Iterator
from pathlib import Path

from softhand_common.documents.output_file import write_file

ROOT = Path(__file__).parents[1]
PAGE = ROOT / "docs" / "reference" / "errata.md"
HEAD = """# Errata of the thesis

Where is the thesis in error, and what does the code use instead?

    make docs      # writes this page from the docstrings that say ERRATUM

R. Deimel, *Soft Robotic Hands For Compliant Grasping* (TU Berlin, 2017). Each entry names the
function whose docstring has the right form; the equations themselves are on
[the page of physics](../understand/physics.md).

"""


def errata(docstring: str) -> list[str]:
    """The sentences behind each ERRATUM of a docstring, up to the next one or the paragraph's end.

    >>> errata("Sum. ERRATUM: the sign of 3.4 is wrong. It is plus. ERRATUM: so is 3.5.")
    ['the sign of 3.4 is wrong. It is plus.', 'so is 3.5.']
    """
    found = []
    for paragraph in re.split(r"\n\s*\n", docstring):
        text = " ".join(paragraph.split())
        found += [_close(part).strip() for part in text.split("ERRATUM: ")[1:]]
    return found


def _close(text: str) -> str:
    """The text up to a parenthesis that was opened before it began."""
    depth = 0
    for place, character in enumerate(text):
        depth += {"(": 1, ")": -1}.get(character, 0)
        if depth < 0:
            return text[:place] + "."
    return text


def documented(folder: Path) -> Iterator[tuple[str, str]]:
    """(dotted name, docstring) of all modules, classes and functions below a folder."""
    for path in sorted(folder.rglob("*.py")):
        module = ".".join(path.relative_to(folder.parent).with_suffix("").parts)
        tree = ast.parse(path.read_text())
        yield module, ast.get_docstring(tree) or ""
        for node in ast.walk(tree):
            if isinstance(node, ast.ClassDef | ast.FunctionDef):
                yield f"{module}.{node.name}", inspect.cleandoc(ast.get_docstring(node) or "")


def page() -> str:
    """The whole page."""
    rows = []
    packages = [init.parent for init in sorted((ROOT / "src").glob("*/*/__init__.py"))]
    for folder in [*packages, ROOT / "thesis"]:
        for name, docstring in documented(folder):
            for text in errata(docstring):
                rows.append(f"* `{name}`: {text}\n")
    return HEAD + "".join(rows)


if __name__ == "__main__":
    write_file(PAGE, page())
