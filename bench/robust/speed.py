"""Speed over ROS beside the same grasp in process, in turns, and the driver's share of a core.

What is compared are whole grasps at 2 ms with 5 segments an actuator: strategy, judge and physics
in one process, and over ROS, with the driver in the simulator's process or in one of its own,
without and with a recorder beside them. In process air follows its command; over ROS there are the
valves, the tubes and the noisy sensors of the plant too.
"""

from __future__ import annotations

import os
import tempfile
import time
from dataclasses import dataclass, field
from pathlib import Path
from statistics import median
from typing import Any

import psutil
from ros_domain import held_domain

from bench import simulator
from bench.pneumatics.driver_process import cpu_share
from bench.row import at_least, at_most, stated
from softhand_bringup.processes import suite
from softhand_bringup.processes.suite import SuiteOptions
from softhand_bringup.ros.demo import Demo
from softhand_trials.trials import Placement, TrialSettings, draw_placement, started_scene

ROUNDS = 5
STEP, SEGMENTS = 0.002, 5
# least ratio to in process without and with a recorder, by where the driver runs
LEAST = {suite.COMPOSED: (0.6, 0.5), suite.TOPIC: (0.45, 0.4)}
SUITE_TIME = 0.35  # CPU time of simulator, driver and sequencer a simulated second, composed [s]
DRIVER, WATCHED = 15.0, 20.0  # share of a core [%] over so long [s]
RECORDER = "recorder"
NODES = {
    "softhand_bringup.ros.hand_with_box": "simulator with driver",
    "pneuflex_sim": "simulator",
    "pneumaticbox_driver": "driver",
    "grasp_strategies": "sequencer",
    "softhand_bringup.ros.recorder": RECORDER,
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
        package = next((p for p in NODES if f"-m {p}" in " ".join(process.cmdline())), None)
        if package is not None:
            spent = process.cpu_times()
            times[NODES[package]] = spent.user + spent.system
    return times


def in_process(seed: int) -> tuple[float, float]:
    """Real-time factor of one grasp without ROS, and its CPU time a simulated second [s]."""
    started = started_scene(TrialSettings())
    placement = Placement(*draw_placement(seed))
    wall, cpu = time.perf_counter(), time.process_time()
    started.run(placement)
    wall, cpu = time.perf_counter() - wall, time.process_time() - cpu
    return started.scene.time / wall, cpu / started.scene.time


def over_ros(seed: int, record: bool, driver: str) -> tuple[float, dict[str, float]]:
    """Real-time factor of one grasp over ROS, as fast as it goes, and its nodes' CPU times."""
    offset, mass_scale = draw_placement(seed)
    options = SuiteOptions(
        object_offset=offset,
        object_mass_scale=mass_scale,
        seed=seed,
        step=STEP,
        driver=driver,
    )
    with tempfile.TemporaryDirectory() as folder, held_domain() as domain:
        os.environ["ROS_DOMAIN_ID"] = str(domain)
        demo = WatchedDemo(options, Path(folder), lambda line: None, record=record)
        factor = demo.run().real_time_factor
    return factor, demo.cpu()


def run(rounds: int = ROUNDS) -> list[dict[str, Any]]:
    """Ratios of the real-time factors, CPU time of the nodes, share of the driver."""
    in_process(0)  # compile
    kinds = [(driver, record) for driver in LEAST for record in (False, True)]
    alone: list[float] = []
    alone_cpu: list[float] = []
    factors: dict[tuple[str, bool], list[float]] = {kind: [] for kind in kinds}
    spent: dict[tuple[str, bool], list[dict[str, float]]] = {kind: [] for kind in kinds}
    for seed in range(rounds):
        factor, time_alone = in_process(seed)
        alone.append(factor)
        alone_cpu.append(time_alone)
        for driver, record in kinds:
            factor, cpu = over_ros(seed, record, driver)
            factors[driver, record].append(factor)
            spent[driver, record].append(cpu)
        line = ", ".join(f"{_words(*kind)} {factors[kind][-1]:.2f}" for kind in kinds)
        print(f"  seed {seed}: in process {alone[-1]:.2f}, {line}", flush=True)
    steps = simulator.grasp(SEGMENTS, STEP)
    rows = [
        stated("grasp in process, 2 ms: real-time factor", median(alone), ""),
        stated("of it the physics alone", steps.steps * STEP / steps.total, ""),
        stated("grasp in process: CPU time a simulated second", median(alone_cpu), "s"),
    ]
    for kind in kinds:
        driver, record = kind
        words, least = _words(driver, record), LEAST[driver][record]
        rows.append(stated(f"{words}: real-time factor", median(factors[kind]), ""))
        rows.append(at_least(f"{words} / in process", ratio(factors[kind], alone), "", least))
        for name in spent[kind][0]:
            time = median(cpu[name] for cpu in spent[kind])
            rows.append(stated(f"{words}: CPU time a simulated second, {name}", time, "s"))
    suite_time = median(sum(cpu.values()) for cpu in spent[suite.COMPOSED, False])
    name = "composed: CPU time a simulated second, whole suite"
    rows.append(at_most(name, suite_time, "s", SUITE_TIME))
    share = 100 * cpu_share(WATCHED)
    rows.append(at_most("driver, 8 channels, 500 Hz: share of one core", share, "%", DRIVER))
    return rows


def _words(driver: str, record: bool) -> str:
    name = "composed" if driver == suite.COMPOSED else "three processes"
    return f"{name}{', recorded' * record}"


def ratio(factors: list[float], others: list[float]) -> float:
    """Median of the ratios of each pair."""
    return median(a / b for a, b in zip(factors, others, strict=True))
