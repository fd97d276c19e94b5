"""What tests of killed sweeps and searches need: how far they are, and their workers."""

import time

import psutil

from grasp_strategies.sweep import read_results


def await_results(folder, count):
    end = time.monotonic() + 90
    while len(read_results(folder)) < count:
        assert time.monotonic() < end, f"{count} results have not come in 90 s"
        time.sleep(0.02)


def workers(process):
    """Spawned workers, without the tracker of resources."""
    return [
        child
        for child in psutil.Process(process.pid).children()
        if "spawn_main" in " ".join(child.cmdline())
    ]
