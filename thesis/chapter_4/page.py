"""What the page on the experiments takes from their results: verdict and table, and pictures.

`python -m thesis.chapter_4.page NAME` prints those of out/pneumatics/NAME in
Markdown; `--copy FOLDER` copies the pictures of all.
"""

import argparse
import shutil
import sys
from collections.abc import Sequence
from pathlib import Path

from thesis.chapter_4.command import EXPERIMENTS, OUT
from thesis.chapter_4.report import Metric, Report, ResultFolder


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command; returns its exit status, 2 if there is no such result."""
    parser = argparse.ArgumentParser(prog="page", description=(__doc__ or "").splitlines()[0])
    parser.add_argument("name", nargs="?", choices=EXPERIMENTS)
    parser.add_argument("--copy", type=Path, metavar="FOLDER", help="copy the pictures of all")
    given = parser.parse_args(arguments)
    try:
        if given.name:
            print(markdown(OUT / given.name))
        if given.copy:
            copy_pictures(given.copy)
    except (ValueError, OSError) as reason:
        print(f"page: {reason}", file=sys.stderr)
        return 2
    return 0


def markdown(folder: Path) -> str:
    """Verdict and metrics of the result in a folder.

    Raises:
        ValueError: there is none.
    """
    content, _ = ResultFolder(folder).read()
    report = Report(tuple(Metric(**m) for m in content["metrics"]), content["verdict"])
    sentence = report.verdict[0].upper() + report.verdict[1:] + "."
    return f"{sentence}\n\n{report.as_table()}"


def copy_pictures(target: Path) -> None:
    """Copy the picture of every experiment that there is a result of, as NAME.png."""
    target.mkdir(parents=True, exist_ok=True)
    for name in EXPERIMENTS:
        figure = ResultFolder(OUT / name).figure
        if figure.exists():
            shutil.copyfile(figure, target / f"{name}.png")


if __name__ == "__main__":
    sys.exit(main())
