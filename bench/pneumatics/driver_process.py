"""CPU time of the real driver process: 8 channels on the embedded bench at 500 Hz."""

from __future__ import annotations

import os
import tempfile
import time
from pathlib import Path

import numpy as np
from ros_domain import held_domain

from softhand_bringup.processes.launcher import Launcher, NodeCommand
from softhand_bringup.processes.suite import node_environment

CHANNELS = list("abcdefgh")
VOLUME, LIMIT, RATE = 1e-4, 1.5e5, 500.0
START = 3.0  # in which a driver that cannot start has ended [s]
AFTER_START = 5.0  # for what is compiled and imported once [s]


def cpu_share(watched: float) -> float:
    """CPU time over wall time while all channels follow a sine, over `watched` [s]."""
    from pneumaticbox_driver.ros.client import PneumaticboxClient

    with tempfile.TemporaryDirectory() as folder, held_domain() as domain:
        environment = node_environment(Path(folder), domain)
        # the client runs here, in the same domain and with the same discovery
        os.environ.update({k: v for k, v in environment.items() if k.startswith(("ROS", "FAST"))})
        with Launcher(Path(folder), environment) as launcher:
            driver = launcher.start(
                NodeCommand("driver", "pneumaticbox_driver.ros.node", _embedded())
            )
            time.sleep(START)
            launcher.check()
            with PneumaticboxClient(patience=60.0, domain=domain) as client:
                client.run(*_sine(AFTER_START + watched + 5.0))
            time.sleep(AFTER_START)
            launcher.check()
            began, before = time.monotonic(), cpu_time(driver.pid)
            time.sleep(watched)
            launcher.check()
            return (cpu_time(driver.pid) - before) / (time.monotonic() - began)


def cpu_time(pid: int) -> float:
    """CPU time of a process and all of its threads so far [s]."""
    # after the name in parentheses come state, parent ...; utime and stime are fields 14 and 15
    fields = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def _embedded() -> dict[str, object]:
    n = len(CHANNELS)
    return {
        "backend": "embedded",
        "channels": CHANNELS,
        "rest_volumes": [VOLUME] * n,
        "pressure_limits": [LIMIT] * n,
        "embedded_rate": RATE,
    }


def _sine(duration: float) -> tuple[dict[str, list[float]], list[float]]:
    times = np.arange(0.1, duration, 0.1)
    course = {name: (3e-5 - 2e-5 * np.cos(times + k)).tolist() for k, name in enumerate(CHANNELS)}
    return course, times.tolist()
