"""`python -m thesis.equilibrium_point`, which `make equilibrium` runs: pushes on a finger.

Exit status: 0 the controllers act as in Figs 4.1 and 4.2; 1 they do not, or something failed; 2
nothing could be started; 130 interrupted.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from threading import Event

from softhand_bringup.processes.run_folder import Say, run_command
from thesis.equilibrium_point.session import Session


def main(arguments: list[str] | None = None) -> int:
    """Push, draw, judge; see the module for the exit status."""
    parsed = _parse(arguments)

    def play(folder: Path, say: Say, stopped: Event) -> bool:
        return show(folder, parsed.seed, say, stopped)

    return run_command("equilibrium", parsed.out, play)


def show(folder: Path, seed: int, say: Say, stopped: Event) -> bool:
    """Push under every controller; whether it came out as in the thesis."""
    # imported late: with --help nobody should wait for PyBullet
    from thesis.equilibrium_point import verdict
    from thesis.equilibrium_point.course import read_courses
    from thesis.equilibrium_point.picture import draw

    session = Session(folder, seed, say, stopped=stopped)
    courses = read_courses(session.bag, session.run())
    outcomes = [verdict.outcome(course) for course in courses]
    draw(courses, folder / "equilibrium.png")
    verdict.write(folder / "result.json", outcomes, seed)
    say(verdict.line(outcomes))
    say(f"bag {session.bag}, picture {folder}/equilibrium.png, figures {folder}/result.json")
    return verdict.as_in_the_thesis(outcomes)


def _parse(arguments: list[str] | None) -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        prog="equilibrium",
        description="A finger pressed on a table under mass, pressure and volume control: the push "
        "moves pressure and volume along the line of equal air mass; the valves stay closed under "
        "mass control alone (Figs 4.1 and 4.2).",
    )
    parser.add_argument("--seed", type=int, default=0, help="of sensor noise and valve jitter")
    parser.add_argument("--out", type=Path, default=Path("out"), help="folder of all runs")
    return parser.parse_args(arguments)


if __name__ == "__main__":
    sys.exit(main())
