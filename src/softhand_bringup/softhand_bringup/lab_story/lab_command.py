"""Commands of the lab, each in a process of its own."""

from __future__ import annotations

import shlex
import subprocess
import sys
from collections.abc import Callable
from threading import Event

from softhand_bringup.processes.waiting import Interrupted, RunFailed

LAB_PROGRAM = "model-lab"


def run_lab(say: Callable[[str], None], stopped: Event, *arguments: object) -> None:
    """Run a command of the lab in a process of its own: the lab forks workers, and a process with
    ROS must not be forked.

    Raises RunFailed if it ends with an error, Interrupted if `stopped` was set meanwhile.
    """
    words = [str(argument) for argument in arguments]
    say(f"$ {shlex.join([LAB_PROGRAM, *words])}")
    done = subprocess.run([sys.executable, "-m", "model_lab", *words], check=False)
    if stopped.is_set():
        raise Interrupted
    if done.returncode != 0:
        raise RunFailed(f"{LAB_PROGRAM} {words[0]} ended with status {done.returncode}")
