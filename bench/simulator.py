"""The whole hand in contact without ROS: speed, contacts, drift of the held object, time outside PyBullet.

One grasp a case, on one core, air through valves and chokes: go down, close, settle, lift, hold 1 s.
"""

from __future__ import annotations

import time
from dataclasses import dataclass, field
from unittest import mock

import numpy as np
import pybullet
from scipy.spatial.transform import Rotation

from bench.row import at_least, at_most, stated
from pneuflex_sim.simulation import Simulation, SimulationConfig

STEPS = (0.001, 0.002, 0.005, 0.01)
SEGMENTS = (5, 15)
FACTOR_TARGETS = {(5, 0.001): 1.5, (15, 0.001): 0.5}
OUTSIDE_TARGET = 5.0  # [us] a segment and step, that of the prototype
DRIFT_TARGET = 1.0  # [mm] in 1 s
ACTUATORS = 6
MASSES = np.array([7.1e-5, 2.4e-5, 5.3e-5, 4.3e-5])  # of the surface-constrained grasp [kg]
PITCH = Rotation.from_euler("y", 135, degrees=True).as_quat()
DOWN, LIFT = np.array([-0.057, 0.0, 0.110]), np.array([0.0, 0.0, 0.125])
PHASES = {"descend": 1.0, "close": 3.2, "settle": 0.3, "lift": 1.0, "calm": 0.3, "hold": 1.0}  # [s]


@dataclass
class Grasp:
    """What one grasp measured: times [s], contacts, object positions in the wrist frame [m]."""

    wall: float = 0.0
    inside: float = 0.0
    steps: int = 0
    contacts: list[int] = field(default_factory=list)
    held: list[np.ndarray] = field(default_factory=list)
    height: float = 0.0

    @property
    def drift(self) -> float:
        """Largest distance [m] of the object from where it was in the hand when the hold began."""
        return float(np.linalg.norm(np.array(self.held) - self.held[0], axis=1).max())


def grasp(segments: int, step: float) -> Grasp:
    """Run one grasp with the time inside `stepSimulation` told apart."""
    simulation, result = Simulation(SimulationConfig(segments=segments, step=step)), Grasp()
    inner = pybullet.stepSimulation

    def timed(**arguments: int) -> None:
        start = time.perf_counter()
        inner(**arguments)
        result.inside += time.perf_counter() - start

    with mock.patch.object(pybullet, "stepSimulation", timed):
        for phase, duration in PHASES.items():
            _run_phase(simulation, result, phase, round(duration / step))
    result.height = float(simulation.object_pose()[0][2])
    simulation.close()
    return result


def _run_phase(simulation: Simulation, result: Grasp, phase: str, steps: int) -> None:
    target = MASSES if phase != "descend" else np.zeros(4)
    for k in range(steps):
        share = (k + 1) / steps
        lifted = {"lift": share, "calm": 1.0, "hold": 1.0}.get(phase, 0.0)
        start = time.perf_counter()
        simulation.command_wrist(DOWN + lifted * LIFT, PITCH)
        simulation.step((simulation.air_masses() < target).astype(int))
        result.wall += time.perf_counter() - start
        result.steps += 1
        if phase == "hold" and k % max(1, steps // 50) == 0:
            place, turn = simulation.wrist_pose()
            held = Rotation.from_quat(turn).inv().apply(simulation.object_pose()[0] - place)
            result.held.append(held)
            result.contacts.append(len(simulation.object_contacts()))


def run() -> list[dict]:
    """Rows of the benchmark."""
    grasp(5, 0.01)  # compile
    rows = []
    for segments in SEGMENTS:
        for step in STEPS:
            rows += _rows(segments, step, grasp(segments, step))
    return rows


def _rows(segments: int, step: float, result: Grasp) -> list[dict]:
    name = f"hand in contact, {segments} segments, {1e3 * step:g} ms"
    factor = result.steps * step / result.wall
    outside = 1e6 * (result.wall - result.inside) / result.steps / (ACTUATORS * segments)
    speed = f"{name}: real-time factor"
    least = FACTOR_TARGETS.get((segments, step))
    return [
        stated(speed, factor, "") if least is None else at_least(speed, factor, "", least),
        at_most(f"{name}: outside stepSimulation a segment", outside, "us", OUTSIDE_TARGET),
        stated(f"{name}: contact points in the hold", float(np.mean(result.contacts)), ""),
        at_least(f"{name}: object lifted", 1e3 * result.height, "mm", 100),
        at_most(f"{name}: drift in 1 s", 1e3 * result.drift, "mm", DRIFT_TARGET),
    ]
