"""`python -m softhand_bringup.equilibrium`, which `make equilibrium` runs: pushes on a finger.

Exit status: 0 the controllers act as in Figs 4.1 and 4.2; 1 they do not, or something failed; 2
nothing could be started; 130 interrupted.
"""

from __future__ import annotations

import argparse
import signal
import sys
from pathlib import Path
from threading import Event

from softhand_bringup.bench_link.waiting import Interrupted, RunFailed
from softhand_bringup.demo.folder import make_run_folder
from softhand_bringup.equilibrium.session import Session
from softhand_bringup.launcher import NodeDied


def main(arguments: list[str] | None = None) -> int:
    """Push, draw, judge; see the module for the exit status."""
    parsed = _parse(arguments)
    try:
        folder = make_run_folder(parsed.out, "equilibrium")
    except OSError as error:
        say(f"cannot write {error.filename or parsed.out}: {error.strerror}")
        return 2
    stopped = Event()
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, lambda *_: stopped.set())
    try:
        return 0 if show(folder, parsed.seed, stopped) else 1
    except (RunFailed, NodeDied, ValueError, OSError) as error:
        say(str(error))
        return 1
    except Interrupted:
        say(f"interrupted; what was recorded is in {folder}")
        return 130


def show(folder: Path, seed: int, stopped: Event) -> bool:
    """Push under every controller; whether it came out as in the thesis."""
    # imported late: with --help nobody should wait for PyBullet
    from softhand_bringup.equilibrium import verdict
    from softhand_bringup.equilibrium.course import read_courses
    from softhand_bringup.equilibrium.picture import draw

    session = Session(folder, seed, say, stopped=stopped)
    courses = read_courses(session.bag, session.run())
    outcomes = [verdict.outcome(course) for course in courses]
    draw(courses, folder / "equilibrium.png")
    verdict.write(folder / "result.json", outcomes, seed)
    say(verdict.line(outcomes))
    say(f"bag {session.bag}, picture {folder}/equilibrium.png, figures {folder}/result.json")
    return verdict.as_in_the_thesis(outcomes)


def say(line: str) -> None:
    """Print one line at once."""
    print(f"equilibrium: {line}", flush=True)


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
