"""Set the version of all packages at once: `.venv/bin/python scripts/set_version.py 0.2.0`.

Without a version it prints the one there is; exit status 1 when the files differ. It stands in
`setup.py` and `package.xml` of every package, which are built on their own, and in `CITATION.cff`.
"""

from __future__ import annotations

import argparse
import re
import sys
from collections.abc import Iterator
from pathlib import Path

from softhand_common.documents.output_file import write_files

ROOT = Path(__file__).parents[1]
PLACES = {
    "src/*/setup.py": re.compile(r'(?<=    version=")[^"]+(?=")'),
    "src/*/package.xml": re.compile(r"(?<=<version>)[^<]+(?=</version>)"),
    "CITATION.cff": re.compile(r"(?<=^version: ).+$", re.MULTILINE),
}


def files(root: Path = ROOT) -> Iterator[tuple[Path, re.Pattern[str]]]:
    """Every file that holds the version, with what matches it there."""
    for pattern, version in PLACES.items():
        yield from ((path, version) for path in sorted(root.glob(pattern)))


def versions(root: Path = ROOT) -> dict[Path, str]:
    """The version that each file holds; raises ValueError for a file without one."""
    found = {path: pattern.search(path.read_text("utf-8")) for path, pattern in files(root)}
    for path, match in found.items():
        if match is None:
            raise ValueError(f"{path}: expected a version, got none")
    return {path: match[0] for path, match in found.items() if match}


def set_version(version: str, root: Path = ROOT) -> None:
    """Write the version into every file, or into none."""
    write_files(
        {
            path: pattern.sub(version, path.read_text("utf-8"), count=1)
            for path, pattern in files(root)
        }
    )


def main(arguments: list[str] | None = None) -> int:
    """Set the version, or print it."""
    parser = argparse.ArgumentParser(prog="set_version", description=__doc__)
    parser.add_argument("version", nargs="?", help="such as 0.2.0; without it, print what there is")
    wanted = parser.parse_args(arguments).version
    if wanted is not None:
        if not re.fullmatch(r"\d+\.\d+\.\d+", wanted):
            parser.error(f"version: expected three numbers with dots, got {wanted}")
        set_version(wanted)
    found = versions()
    for version in sorted(set(found.values())):
        print(version, *([] if len(set(found.values())) == 1 else _holding(found, version)))
    return int(len(set(found.values())) > 1)


def _holding(found: dict[Path, str], version: str) -> list[str]:
    return [str(path.relative_to(ROOT)) for path, one in found.items() if one == version]


if __name__ == "__main__":
    sys.exit(main())
