"""Finished parts of a long bench, one line of JSON each: it goes on where it was stopped."""

from __future__ import annotations

import ast
import hashlib
import json
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[1]


class Unfinished(RuntimeError):
    """The time of a bench is over; started again, it goes on."""


def revision_of(sources: Iterable[str], suffixes: tuple[str, ...] = (".py",)) -> str:
    """A short digest of files in folders, whose change makes old results stale. Comments and
    docstrings of Python may change."""
    digest = hashlib.sha256()
    for source in sources:
        for file in sorted((ROOT / source).rglob("*")):
            if file.suffix == ".py" and ".py" in suffixes:
                digest.update(statements(file.read_text()).encode())
            elif file.suffix in suffixes:
                digest.update(file.read_bytes())
    return digest.hexdigest()[:12]


def statements(source: str) -> str:
    """Python source without layout, comments and docstrings.

    >>> statements("def f():\\n    'One.'\\n    return 1") == statements("def f(): return 1  # 1")
    True
    """
    tree = ast.parse(source)
    for node in ast.walk(tree):
        body = getattr(node, "body", None)
        if isinstance(body, list) and body and _is_text(body[0]):
            del body[0]
    return ast.dump(tree)


def _is_text(statement: ast.stmt) -> bool:
    return isinstance(statement, ast.Expr) and isinstance(statement.value, ast.Constant)


def read(path: Path) -> dict[str, dict[str, Any]]:
    """Finished parts by key; a line that was cut off while writing is left out."""
    found = {}
    for line in path.read_text().splitlines() if path.is_file() else []:
        try:
            record = json.loads(line)
        except json.JSONDecodeError:
            continue
        found[record["key"]] = record
    return found


def append(record: dict[str, Any], path: Path) -> None:
    """Keep one finished part."""
    path.parent.mkdir(parents=True, exist_ok=True)
    with path.open("a") as file:
        file.write(json.dumps(record) + "\n")


class Once:
    """What runs find, kept in a file; a run is done again only when the sources change."""

    def __init__(self, path: Path, sources: Iterable[str]) -> None:
        self.path, self.known = path, read(path)
        self.revision = revision_of(sources, (".py", ".yaml"))

    def __call__(self, name: str, run: Callable[[], Any]) -> Any:
        """What the run of this name finds, or has found with these sources."""
        key = f"{self.revision}: {name}"
        if key not in self.known:
            self.known[key] = {"key": key, "found": run()}
            append(self.known[key], self.path)
        return self.known[key]["found"]
