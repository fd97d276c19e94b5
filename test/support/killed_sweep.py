"""Sweeps and searches whose workers are killed, and who are killed themselves and run again."""

import os
import signal
import subprocess
import sys
import time
from contextlib import suppress

import psutil

from softhand_trials.sweep import read_results

# Tasks that are run again, as they had no line: that of the killed worker, and of the killed
# command one of each of two workers, and one that ended, whose worker had already begun the next.
RUN_AGAIN = 1 + 3


def killed_and_run_again(command, folder, count):
    """Kill a worker of a command as soon as `folder` has three results, and the command itself as
    soon as it has `count`; run it again to its end. Its output then, and all its records: every
    finished line is kept, and no key comes twice.
    """
    running = start(command)
    await_results(folder, 3)
    workers(running)[0].send_signal(signal.SIGKILL)
    await_results(folder, count)
    left = workers(running)
    running.kill()
    running.communicate()
    assert psutil.wait_procs(left, timeout=20)[1] == [], "a worker has outlived its command"
    before = (folder / "results.jsonl").read_bytes()
    again = start(command)
    output, errors = again.communicate(timeout=90)
    assert again.returncode == 0, errors
    finished = before[: before.rfind(b"\n") + 1]
    assert (folder / "results.jsonl").read_bytes().startswith(finished)
    records = read_results(folder)
    assert len({record["key"] for record in records}) == len(records)
    return output, records


def start(command):
    """Start a Python program; its workers find the modules that the tests do."""
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)}
    line = [sys.executable, *map(str, command)]
    pipe = subprocess.PIPE
    return subprocess.Popen(line, stdout=pipe, stderr=pipe, text=True, env=environment)


def await_results(folder, count):
    end = time.monotonic() + 90
    while len(read_results(folder)) < count:
        assert time.monotonic() < end, f"{count} results have not come in 90 s"
        time.sleep(0.02)


def workers(process):
    """Spawned workers, without the tracker of resources and those that have ended."""
    found = []
    for child in psutil.Process(process.pid).children():
        with suppress(psutil.NoSuchProcess):
            if "spawn_main" in " ".join(child.cmdline()):
                found.append(child)
    return found
