"""The prototype's grasp in this simulator: six equal fingers close on a cylinder and lift it.

The same places, sizes, masses, friction, boxes, iterations and course of time as in
`implicit_chain.py`. What differs: the fingers are P10 actuators by this project's own physics (the
prototype takes 1.5 and 0.7 of the bending stiffness sideways and in twist, 25 g a finger and
kappa(p) by eq. 5.2), the air is a mass in a chamber that follows the shape (there a pressure), and
the fingers hang on a compliant wrist whose load is felt (there on six slides driven by motors). The
pressure is chosen so that both grip with the same force.
"""

from __future__ import annotations

import math
import time
from dataclasses import replace
from pathlib import Path

import numpy as np

from bench.sim.random_trials import masses_at
from pneuflex_sim.scene.friction import FrictionTable
from pneuflex_sim.scene.objects import ObjectDescription
from pneuflex_sim.scene.scenes import load_scene
from pneuflex_sim.simulation import Simulation, SimulationConfig

HAND = Path(__file__).parent / "data" / "six_fingers.yaml"
HEIGHT = 0.098  # of the mounts above the table [m]
PRESSURE = 20e3  # [Pa]: the cylinder is gripped with 5.5 N in all, as by the prototype (5.8 N)
CLOSE, SETTLE, LIFT, HOLD = 0.8, 0.4, 0.8, 1.0  # [s]
RISE = 0.1  # [m]
CYLINDER = ObjectDescription(
    "cylinder",
    "cylinder",
    {"diameter": 0.06, "length": 0.12},
    0.2,
    "cylinder",
    (math.pi / 2, 0.0, 0.0),
)
FRICTION = FrictionTable(
    {
        frozenset(pair): coefficient
        for pair, coefficient in (
            (("rubber",), 1.0),
            (("rubber", "cylinder"), 0.8),
            (("rubber", "wood"), 0.6),
            (("cylinder", "wood"), 0.48),
        )
    }
)


def build(segments: int, step: float, parts: int = 1) -> Simulation:
    """The scene, at rest; the cylinder touches as one shape as the prototype's, or as `parts`."""
    scene = replace(
        load_scene("table"), wrist_position=(0.0, 0.0, HEIGHT), wrist_rpy=(math.pi, 0.0, 0.0)
    )
    return Simulation(
        SimulationConfig(
            hand=str(HAND),
            object=replace(CYLINDER, dimensions={**CYLINDER.dimensions, "parts": parts}),
            scene=scene,
            step=step,
            segments=segments,
            collision="boxes",
            friction=FRICTION,
        )
    )


def closed_mass(simulation: Simulation, pressure: float = PRESSURE) -> np.ndarray:
    """Air masses [kg above rest] that give a gauge pressure [Pa] when nothing is touched."""
    return masses_at(simulation, np.array([pressure]))


def grasp(segments: int, step: float) -> dict[str, float]:
    """One grasp: real-time factor by CPU time, height [m] of the object at the end, contacts."""
    simulation = build(segments, step)
    try:
        mass, turn = closed_mass(simulation), simulation.wrist_pose()[1].copy()
        steps = round((CLOSE + SETTLE + LIFT + HOLD) / step)
        spent = 0.0
        for k in range(steps):
            begin = time.thread_time()
            t = k * step
            x = min(max((t - CLOSE - SETTLE) / LIFT, 0.0), 1.0)
            height = HEIGHT + RISE * (3 * x * x - 2 * x**3)
            simulation.command_wrist(np.array([0.0, 0.0, height]), turn)
            simulation.set_air_masses(mass * min(1.0, t / CLOSE))
            simulation.step()
            spent += time.thread_time() - begin
        height = float(simulation.object_pose()[0][2])
        contacts = len(simulation.object_contacts())
        return {"factor": steps * step / spent, "height": height, "contacts": contacts}
    finally:
        simulation.close()
