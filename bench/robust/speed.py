"""Speed over ROS beside the same grasp in process, in turns, and the driver's share of a core.

What is compared are whole grasps at 2 ms with 5 segments an actuator: strategy, judge and physics
in one process, and as three nodes, without and with a recorder beside them. In process air follows
its command; over ROS there are the valves, the tubes and the noisy sensors of the plant too.
"""

from __future__ import annotations

import os
import tempfile
from dataclasses import dataclass, field
from pathlib import Path
from statistics import median
from typing import Any

import psutil
from ros_domain import held_domain

from bench import simulator
from bench.pneumatics.driver_process import cpu_share
from bench.row import at_least, at_most, stated
from softhand_bringup.processes.suite import SuiteOptions
from softhand_bringup.ros.demo import Demo
from softhand_trials.trials import draw_placement, run_trial

ROUNDS = 5
STEP, SEGMENTS = 0.002, 5
BARE, RECORDED = 0.45, 0.4  # least ratio without and with a recorder
DRIVER, WATCHED = 25.0, 20.0  # share of a core [%] over so long [s]
NODES = {
    "pneuflex_sim": "simulator",
    "pneumaticbox_driver": "driver",
    "grasp_strategies": "sequencer",
    "softhand_bringup": "recorder",
}


@dataclass
class WatchedDemo(Demo):
    """A grasp that notes the nodes' CPU times [s] when a phase begins, with simulated time [s]."""

    notes: list[tuple[float, dict[str, float]]] = field(default_factory=list)

    def _tell_phase(self, simulated_time: float, name: str) -> None:
        self.notes.append((simulated_time, cpu_times()))

    def cpu(self) -> dict[str, float]:
        """CPU time of each node a simulated second, from the second phase to the last [-]."""
        (begin, before), (end, after) = self.notes[1], self.notes[-1]
        return {name: (after[name] - before[name]) / (end - begin) for name in before}


def cpu_times() -> dict[str, float]:
    """CPU time so far of the nodes that this process has started [s]."""
    times = {}
    for process in psutil.Process().children():
        package = next((p for p in NODES if f"-m {p}." in " ".join(process.cmdline())), None)
        if package is not None:
            spent = process.cpu_times()
            times[NODES[package]] = spent.user + spent.system
    return times


def over_ros(seed: int, record: bool) -> tuple[float, dict[str, float]]:
    """Real-time factor of one grasp over ROS, as fast as it goes, and its nodes' CPU times."""
    offset, mass_scale = draw_placement(seed)
    options = SuiteOptions(object_offset=offset, object_mass_scale=mass_scale, seed=seed, step=STEP)
    with tempfile.TemporaryDirectory() as folder, held_domain() as domain:
        os.environ["ROS_DOMAIN_ID"] = str(domain)
        demo = WatchedDemo(options, Path(folder), lambda line: None, record=record)
        factor = demo.run().real_time_factor
    return factor, demo.cpu()


def run(rounds: int = ROUNDS) -> list[dict[str, Any]]:
    """Ratios of the real-time factors, CPU time of the nodes, share of the driver."""
    run_trial(0)  # compile
    rows, bare, recorded, alone = [], [], [], []
    spent: dict[str, list[float]] = {}
    for seed in range(rounds):
        alone.append(run_trial(seed).real_time_factor)
        for factors, record in ((bare, False), (recorded, True)):
            factor, cpu = over_ros(seed, record)
            factors.append(factor)
            for name, time in cpu.items():
                spent.setdefault(f"{name}{', with recorder' * record}", []).append(time)
        line = f"in process {alone[-1]:.2f}, over ROS {bare[-1]:.2f}, recorded {recorded[-1]:.2f}"
        print(f"  seed {seed}: {line}", flush=True)
    steps = simulator.grasp(SEGMENTS, STEP)
    rows += [
        stated("grasp in process, 2 ms: real-time factor", median(alone), ""),
        stated("of it the physics alone", steps.steps * STEP / steps.total, ""),
        stated("grasp over ROS: real-time factor", median(bare), ""),
        stated("grasp over ROS with recorder: real-time factor", median(recorded), ""),
        at_least("over ROS / in process", ratio(bare, alone), "", BARE),
        at_least("over ROS with recorder / in process", ratio(recorded, alone), "", RECORDED),
    ]
    for name, times in spent.items():
        rows.append(stated(f"CPU time a simulated second: {name}", 1e3 * median(times), "ms"))
    share = 100 * cpu_share(WATCHED)
    rows.append(at_most("driver, 8 channels, 500 Hz: share of one core", share, "%", DRIVER))
    return rows


def ratio(factors: list[float], others: list[float]) -> float:
    """Median of the ratios of each pair."""
    return median(a / b for a, b in zip(factors, others, strict=True))
