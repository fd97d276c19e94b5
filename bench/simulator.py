"""The surface-constrained grasp in process, without ROS, on one core: speed, contacts, drift.

Air follows its command at the pace of the chokes, as in batch trials; what the full plant of
valves, tubes and sensors costs beside that is a row of its own.
"""

from __future__ import annotations

import time
from dataclasses import dataclass, field
from importlib import resources
from typing import Any
from unittest import mock

import numpy as np

from bench.row import at_least, at_most, stated
from grasp_strategies.judging.judge import GraspResult
from pneuflex_sim.bullet import pybullet
from pneuflex_sim.scene.contacts import Contact
from pneuflex_sim.simulation import Simulation, SimulationConfig
from softhand_model.pneumatics.plant import PneumaticPlant
from softhand_trials.trials import TrialSettings, run_trial

STEPS = (0.001, 0.002, 0.005, 0.01)
SEGMENTS = (5, 15)
FACTOR_TARGETS = {(5, 0.001): 1.5, (15, 0.001): 0.5}
OUTSIDE_TARGET = 5.0  # [us] a segment and step, that of the prototype
DRIFT_TARGET = 1.0  # [mm] in the hold of 1.1 s
ACTUATORS = 6
FINGER_MASS = 1.0e-5  # about 20 kPa in a P10 finger [kg]
RESPONSE = 3.0  # in which it comes to rest [s]


@dataclass
class Timed:
    """What one grasp measured: wall times [s], steps, contact points of the held object."""

    total: float = 0.0
    inside: float = 0.0
    steps: int = 0
    contacts: list[int] = field(default_factory=list)
    result: GraspResult | None = None


def grasp(segments: int, step: float) -> Timed:
    """Run one trial with the time of `Simulation.step` and of Bullet within it told apart."""
    timed = Timed()
    inner, outer, contacts = pybullet.stepSimulation, Simulation.step, Simulation.object_contacts

    def step_bullet(**arguments: int) -> None:
        start = time.perf_counter()
        inner(**arguments)
        timed.inside += time.perf_counter() - start

    def step_all(simulation: Simulation, valves: Any = None) -> None:
        start = time.perf_counter()
        outer(simulation, valves)
        timed.total += time.perf_counter() - start
        timed.steps += 1

    def count_contacts(simulation: Simulation) -> list[Contact]:
        found = contacts(simulation)
        timed.contacts.append(len(found))
        return found

    with (
        mock.patch.object(pybullet, "stepSimulation", step_bullet),
        mock.patch.object(Simulation, "step", step_all),
        mock.patch.object(Simulation, "object_contacts", count_contacts),
    ):
        timed.result = run_trial(0, TrialSettings(step=step, segments=segments)).result
    return timed


def plant_step(channels: int, steps: int = 5000) -> float:
    """Wall time [us] of one plant step of 1 ms with all valves open."""
    plant = PneumaticPlant([str(k) for k in range(channels)], np.full(channels, 30e-6))
    valves, volumes = np.ones(channels, int), np.full(channels, 30e-6)
    start = time.perf_counter()
    for _ in range(steps):
        plant.step(0.001, valves, volumes)
    return 1e6 * (time.perf_counter() - start) / steps


def response_time(segments: int, step: float) -> float:
    """Time [ms] in which a weightless finger bends to 90 % after its air is let in at once."""
    model = resources.files("softhand_model").joinpath("data/models/base.yaml")
    finger = SimulationConfig(
        hand="single_finger", scene="stand", step=step, segments=segments, model=model
    )
    simulation, angles = Simulation(finger), []
    simulation.set_air_masses(np.array([FINGER_MASS]))
    for _ in range(round(RESPONSE / step)):
        simulation.step()
        angles.append(simulation.tip_angles()["finger"])
    simulation.close()
    return 1e3 * step * (1 + int(np.argmax(np.array(angles) > 0.9 * angles[-1])))


def run() -> list[dict[str, Any]]:
    """Rows of the benchmark."""
    grasp(5, 0.01)  # compile
    plant_step(4, 10)
    rows = [stated("plant of 4 channels, a step of 1 ms", plant_step(4), "us")]
    for segments in SEGMENTS:
        for step in STEPS:
            rows += _rows(segments, step, grasp(segments, step))
            name = f"finger, {segments} segments, {1e3 * step:g} ms: time to 90 % of a step"
            rows.append(stated(name, response_time(segments, step), "ms"))
    return rows


def _rows(segments: int, step: float, timed: Timed) -> list[dict[str, Any]]:
    name = f"hand in contact, {segments} segments, {1e3 * step:g} ms"
    factor = timed.steps * step / timed.total
    outside = 1e6 * (timed.total - timed.inside) / timed.steps / (ACTUATORS * segments)
    speed = f"{name}: real-time factor"
    least = FACTOR_TARGETS.get((segments, step))
    result = timed.result
    return [
        stated(speed, factor, "") if least is None else at_least(speed, factor, "", least),
        at_most(f"{name}: outside stepSimulation a segment", outside, "us", OUTSIDE_TARGET),
        stated(f"{name}: contact points of the object", float(np.mean(timed.contacts)), ""),
        at_least(f"{name}: object lifted", 1e3 * result.lift_height, "mm", 100),
        at_most(f"{name}: drift in the hold of 1.1 s", 1e3 * result.slip, "mm", DRIFT_TARGET),
    ]
