"""Six fingers of 30 segments closed hard around a cylinder on the table: more than 100 contacts.

PyBullet also lists points that are near; here those count that touch.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import pybullet

from bench.row import at_least, at_most, stated
from bench.sim import six_fingers
from bench.sim.timing import timed_steps

STEPS = (0.005, 0.001)
SEGMENTS, PRESSURE = 30, 50e3
TOUCH = "contact points that touch"
CLOSE, END = 0.8, 3.0  # [s]
LEAST = 100  # contacts
STILL = 5.0  # [mm] that the cylinder may move in the last second


@dataclass
class Hold:
    """What one run showed: real-time factor; in every tenth step the contact points that touch and
    those of them that carry force; way [m] of the cylinder in the last second.
    """

    factor: float
    touching: list[int]
    loaded: list[int]
    way: float


def close_hard(step: float) -> Hold:
    """One run; raises RuntimeError when it diverges."""
    simulation = six_fingers.build(SEGMENTS, step, parts=2)
    touching, loaded, places = [], [], []
    try:
        mass = six_fingers.closed_mass(simulation, PRESSURE)
        with timed_steps() as times:
            while simulation.time < END:
                simulation.set_air_masses(mass * min(1.0, simulation.time / CLOSE))
                simulation.step()
                if simulation.steps % 10 == 0:
                    points = pybullet.getContactPoints(physicsClientId=simulation.world.client)
                    touching.append(sum(point[8] <= 0.0 for point in points))
                    loaded.append(sum(point[9] > 0.0 for point in points))
                if simulation.time > END - 1.0:
                    places.append(simulation.object_pose()[0])
        way = float(np.linalg.norm(np.ptp(places, axis=0)))
        return Hold(times.factor(step), touching, loaded, way)
    finally:
        simulation.close()


def rows(small: bool) -> list[dict[str, Any]]:
    """Contacts, whether they stay calm, and the real-time factor."""
    found = []
    for step in STEPS[: 1 if small else None]:
        hold = close_hard(step)
        name = f"six fingers closed hard, {6 * SEGMENTS} segments, {1e3 * step:g} ms"
        found += [
            at_least(f"{name}: {TOUCH}, mean of the second half", late(hold.touching), "", LEAST),
            stated(f"{name}: {TOUCH}, most", max(hold.touching), ""),
            stated(f"{name}: of them with force, mean of the second half", late(hold.loaded), ""),
            at_most(f"{name}: the cylinder moves in 1 s", 1e3 * hold.way, "mm", STILL),
            stated(f"{name}: real-time factor", hold.factor, ""),
        ]
    return found


def late(counts: list[int]) -> float:
    """Mean of the second half."""
    return float(np.mean(counts[len(counts) // 2 :]))
