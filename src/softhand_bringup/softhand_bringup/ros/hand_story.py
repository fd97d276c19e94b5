"""The lab's story of a hand over ROS, and the command.

Exit status: 0 all steps done; 1 failed; 2 nothing could be started; 130 interrupted.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from threading import Event

from softhand_bringup.lab_story.hand_story import HIDDEN_SIZES, HandStory
from softhand_bringup.processes.run_folder import Say, run_command
from softhand_bringup.processes.suite import SuiteOptions
from softhand_bringup.ros.demo import Demo

STORY_HAND, BYSTANDER = "rbo_hand_2", "cylinder"  # the object stays on the table, out of reach


def main(arguments: list[str] | None = None) -> int:
    """Run the story; see the module for the exit status."""
    parsed = _parse(arguments)

    def play(folder: Path, say: Say, stopped: Event) -> bool:
        def rig(into: Path, strategy: Path, model: Path) -> Path:
            into.mkdir()
            options = SuiteOptions(
                hand=parsed.hand,
                object=BYSTANDER,
                strategy=str(strategy),
                model=str(model),
                seed=parsed.seed,
            )
            Demo(options, into, say, stopped).run()
            return into / "bag"

        HandStory(rig, folder, parsed.hand, parsed.hide, parsed.seed, say, stopped).run()
        return True

    return run_command("hand-story", parsed.out, play)


def _parse(arguments: list[str] | None) -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        prog="softhand hand-story",
        description="A hand whose simulator hides an effect in one place: recorded over ROS, "
        "diagnosed from the bag, the effect added and given back to the simulator.",
    )
    parser.add_argument("--hide", choices=[*HIDDEN_SIZES], default="crosstalk")
    parser.add_argument("--hand", default=STORY_HAND, help="name, or path of a YAML file")
    parser.add_argument("--seed", type=int, default=0, help="draws place and size of the effect")
    parser.add_argument("--out", type=Path, default=Path("out"), help="folder of all runs")
    return parser.parse_args(arguments)


if __name__ == "__main__":
    sys.exit(main())
