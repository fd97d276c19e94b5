"""`python -m softhand_bringup.lab_story`, which `make lab-story` runs: the lab's whole story live.

Exit status: 0 told to its end; 1 failed; 2 nothing could be started; 130 interrupted.
"""

from __future__ import annotations

import argparse
import signal
import sys
from pathlib import Path
from threading import Event

from softhand_bringup.bench_link.waiting import Interrupted, RunFailed
from softhand_bringup.demo.folder import make_run_folder
from softhand_bringup.lab_story.story import HIDDEN, Story
from softhand_bringup.launcher import NodeDied


def main(arguments: list[str] | None = None) -> int:
    """Tell the story; see the module for the exit status."""
    parsed = _parse(arguments)
    try:
        folder = make_run_folder(parsed.out, "lab-story")
    except OSError as error:
        say(f"cannot write {error.filename or parsed.out}: {error.strerror}")
        return 2
    stopped = Event()
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, lambda *_: stopped.set())
    try:
        Story(folder, parsed.hide, parsed.seed, say, stopped).run()
    except (RunFailed, NodeDied, ValueError, OSError) as error:
        say(str(error))
        return 1
    except Interrupted:
        say(f"interrupted; what was recorded is in {folder}")
        return 130
    return 0


def say(line: str) -> None:
    """Print one line at once."""
    print(f"lab-story: {line}", flush=True)


def _parse(arguments: list[str] | None) -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        prog="lab_story",
        description="A finger whose simulator hides an effect: measured over ROS, diagnosed from "
        "the bags, the effect added, and watched live by the monitor.",
    )
    parser.add_argument("--hide", choices=HIDDEN, default="viscoelasticity")
    parser.add_argument("--seed", type=int, default=0, help="of sensor noise and valve jitter")
    parser.add_argument("--out", type=Path, default=Path("out"), help="folder of all runs")
    return parser.parse_args(arguments)


if __name__ == "__main__":
    sys.exit(main())
