"""A process that ends the nodes of a launcher when the launcher has died, in whatever way.

It reads the process ids of the nodes from its standard input, one per line; its argument is the id
of the launcher. It is run as a file, without the packages, to start quickly and in little memory.
"""

from __future__ import annotations

import contextlib
import os
import select
import signal
import sys
import time

# Each is sent to all that still run, which are given so long [s] before the next, harsher one.
LADDER = ((signal.SIGINT, 5.0), (signal.SIGTERM, 2.0))
START_LIMIT = 2.0  # after the launcher's death, for children that are being started to say so [s]


def watch(launcher: int | None) -> dict[int, int | None]:
    """Wait until the launcher, given by a file descriptor of its process, has died or closed the
    pipe. Returns the processes that it has started: their file descriptors by process id, None for
    a process that ended at once.

    A child that the launcher has just forked holds the pipe open until it runs its program.
    """
    kept: dict[int, int | None] = {}
    pipe, rest = sys.stdin.fileno(), b""
    watched = [pipe] if launcher is None else [pipe, launcher]
    patience = None
    while (ready := select.select(watched, [], [], patience)[0]) or patience is None:
        if launcher in ready:
            watched, patience = [pipe], START_LIMIT
        if pipe in ready:
            read = os.read(pipe, 4096)
            if not read:
                break
            *lines, rest = (rest + read).split(b"\n")
            kept |= {pid: opened_process(pid) for pid in map(int, lines)}
    return kept


def end(kept: dict[int, int | None]) -> None:
    """End the processes that still run, and at last all processes that they have started: each
    leads a process group.
    """
    left = running([opened for opened in kept.values() if opened is not None], 0.0)
    for number, patience in LADDER:
        for each in left:
            signal.pidfd_send_signal(each, number)
        left = running(left, patience)
    for each in left:
        signal.pidfd_send_signal(each, signal.SIGKILL)
    running(left, 2.0)
    for pid in kept:
        end_group(pid)


def end_group(leader: int) -> None:
    """Kill what is left of the process group of a process that has ended.

    The system gives the id of the leader to another process only once its group is empty. So if a
    process with that id runs, the group is not the old one.
    """
    if _runs(leader):
        return
    with contextlib.suppress(ProcessLookupError, PermissionError):
        os.killpg(leader, signal.SIGKILL)


def _runs(pid: int) -> bool:
    try:
        with open(f"/proc/{pid}/stat", "rb") as file:
            return file.read().rpartition(b")")[2].split()[0] != b"Z"
    except OSError:
        return False


def running(opened: list[int], patience: float) -> list[int]:
    """File descriptors of the processes that still run after `patience` [s]; returns sooner if none
    does.
    """
    left, until = opened, time.monotonic() + patience
    while left:
        ended, _, _ = select.select(left, [], [], max(0.0, until - time.monotonic()))
        if not ended:
            break
        left = [each for each in left if each not in ended]
    return left


def opened_process(pid: int) -> int | None:
    """File descriptor of a process, which is readable after its end; None if it has ended."""
    try:
        return os.pidfd_open(pid)
    except ProcessLookupError:
        return None


def main() -> None:
    """Watch the launcher, then end its remaining processes."""
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        signal.signal(number, signal.SIG_IGN)
    end(watch(opened_process(int(sys.argv[1]))))


if __name__ == "__main__":
    main()
