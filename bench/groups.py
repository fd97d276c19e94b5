"""Frame of a benchmark in groups: runs those asked for, prints their table, writes their rows.

Every module of a benchmark's folder with a function `run(...) -> list[dict]` is a group of rows;
those of its arguments that are named as an option of the benchmark get it. `TAKES = "text"` there
says in the help how long it takes on two idle cores.
"""

from __future__ import annotations

import argparse
import ast
import importlib
import inspect
import json
import sys
import traceback
from collections.abc import Mapping, Sequence
from datetime import datetime
from pathlib import Path
from typing import Any

from bench.__main__ import table
from bench.kept import Unfinished

OUT = Path("out/bench")


def groups(package: str) -> list[str]:
    """Names of the modules of a benchmark that measure something, told without importing them."""
    folder = Path(__file__).parent / package
    return [f.stem for f in sorted(folder.glob("*.py")) if "\ndef run(" in f.read_text()]


def _about(package: str, name: str) -> str:
    """First line of a group's module, and how long it `TAKES` if that is said there."""
    tree = ast.parse((Path(__file__).parent / package / f"{name}.py").read_text())
    first = (ast.get_docstring(tree) or "").partition("\n")[0]
    values = [ast.literal_eval(n.value) for n in tree.body if _names(n) == ["TAKES"]]
    return " ".join([first, *(f"({value})" for value in values)])


def _names(node: ast.stmt) -> list[str]:
    """What an assignment names, nothing of another statement."""
    targets = node.targets if isinstance(node, ast.Assign) else []
    return [target.id for target in targets if isinstance(target, ast.Name)]


def measure(package: str, name: str, options: Mapping[str, Any]) -> list[dict[str, Any]]:
    """Rows of one group, with those of the options that it takes."""
    run = importlib.import_module(f"bench.{package}.{name}").run
    taken = inspect.signature(run).parameters
    rows: list[dict[str, Any]] = run(**{k: v for k, v in options.items() if k in taken})
    return rows


def write(package: str, group: str, rows: Sequence[dict[str, Any]]) -> Path:
    """Write the rows of a group in place of its old ones; those of other groups stay."""
    path = OUT / f"bench-{package}.json"
    path.parent.mkdir(parents=True, exist_ok=True)
    before = json.loads(path.read_text()) if path.exists() else []
    kept = [row for row in before if row.get("group", group) != group]
    when = datetime.now().isoformat(" ", "minutes")
    kept += [{"group": group, **row, "measured": when} for row in rows]
    path.write_text(json.dumps(kept, indent=2) + "\n")
    return path


def main(
    package: str,
    description: str,
    own: Mapping[str, tuple[Any, str]],
    arguments: Sequence[str] | None = None,
) -> int:
    """Measure, print, write.

    Args:
        package: folder of the benchmark.
        description: for its help.
        own: its options by name: value unless given, and help.
        arguments: of the command line.

    Returns:
        1 if a group could not be run; a target that is missed shows in the table only.
    """
    names = groups(package)
    parser = argparse.ArgumentParser(
        prog=f"bench.{package}",
        description=description,
        epilog="\n".join(["rows:", *(f"  {name:14s} {_about(package, name)}" for name in names)]),
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--rows", nargs="+", default=names, choices=names, help="default: all")
    for name, (default, help) in own.items():
        text = f"{help} (default: {default:g})"
        parser.add_argument(f"--{name}", type=type(default), default=default, help=text)
    given = vars(parser.parse_args(arguments))
    print(f"bench: {', '.join(f'{name} {given[name]:g}' for name in own)}", flush=True)
    rows, failed = [], []
    for name in given["rows"]:
        print(f"bench: {name} ...", flush=True)
        try:
            found = measure(package, name, given)
            rows += found
            print(f"bench: written to {write(package, name, found)}", flush=True)
        except Unfinished as left:
            failed.append(f"{name} is not finished, start it again to go on: {left}")
        except Exception:  # noqa: BLE001 (one broken group must not hide the others)
            traceback.print_exc()
            failed.append(f"{name} could not be run")
    print(table(rows))
    for what in failed:
        print(f"bench: {what}", file=sys.stderr)
    return 1 if failed else 0
