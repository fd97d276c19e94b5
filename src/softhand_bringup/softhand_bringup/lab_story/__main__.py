"""`python -m softhand_bringup.lab_story`, which `make lab-story` runs: the lab's whole story live.

Exit status: 0 told to its end; 1 failed; 2 nothing could be started; 130 interrupted.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from threading import Event

from softhand_bringup.lab_story.measuring import Plan, Played
from softhand_bringup.lab_story.story import HIDDEN, Story
from softhand_bringup.processes.run_folder import Say, run_command
from softhand_bringup.ros.session import Session


def main(arguments: list[str] | None = None) -> int:
    """Tell the story; see the module for the exit status."""
    parsed = _parse(arguments)

    def play(folder: Path, say: Say, stopped: Event) -> bool:
        def bench(into: Path, plan: Plan, truth: Path, model: str) -> list[Played]:
            return Session(into, plan, truth, model, parsed.seed, say, stopped).run()

        Story(bench, folder, parsed.hide, say, stopped).run()
        return True

    return run_command("lab-story", parsed.out, play)


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
