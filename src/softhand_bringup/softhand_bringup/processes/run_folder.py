"""Runs a command that starts nodes: its output folder, signals and exit status."""

from __future__ import annotations

import itertools
import signal
import time
from collections.abc import Callable
from pathlib import Path
from threading import Event

from softhand_bringup.processes.domain import DomainTaken
from softhand_bringup.processes.launcher import NodeDied
from softhand_bringup.processes.waiting import Interrupted, RunFailed

Say = Callable[[str], None]


def make_run_folder(out: Path, prefix: str = "demo") -> Path:
    """Make `out/<prefix>-<time>` and let the link `out/<prefix>` point to it.

    Raises:
        OSError: the folder cannot be made or written.
    """
    out.mkdir(parents=True, exist_ok=True)
    stem = time.strftime(f"{prefix}-%Y%m%d-%H%M%S")
    for number in itertools.count(1):
        folder = out / (stem if number == 1 else f"{stem}-{number}")
        try:
            folder.mkdir()
            break
        except FileExistsError:
            continue
    _point(out / prefix, folder.name)
    return folder


def _point(link: Path, target: str) -> None:
    """Replace a symbolic link atomically."""
    fresh = link.with_name(f".{link.name}-{target}")
    fresh.symlink_to(target)
    fresh.replace(link)


def run_command(name: str, out: Path, play: Callable[[Path, Say, Event], bool]) -> int:
    """Call `play` with a new folder `out/<name>-<time>`, and print errors.

    Args:
        name: name of the command, which begins every line that it prints.
        out: folder of all runs.
        play: called with the folder, a function that prints a line, and an event that is set at
            SIGINT or SIGTERM; returns whether the run succeeded.

    Returns:
        Exit status: 0 success; 1 no success, or an error; 2 nothing could be started; 130
        interrupted.
    """

    def say(line: str) -> None:
        print(f"{name}: {line}", flush=True)

    try:
        folder = make_run_folder(out, name)
    except OSError as error:
        say(f"cannot write {error.filename or out}: {error.strerror}")
        return 2
    stopped = Event()
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, lambda *_: stopped.set())
    try:
        return 0 if play(folder, say, stopped) else 1
    except DomainTaken as error:
        say(str(error))
        return 2
    except (RunFailed, NodeDied, ValueError, OSError) as error:
        say(str(error))
        return 1
    except Interrupted:
        say(f"interrupted; the recording is in {folder}")
        return 130
