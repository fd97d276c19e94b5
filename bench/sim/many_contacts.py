"""Six fingers of 15 segments closed hard around a cylinder on the table: 100 to 150 contacts."""

from __future__ import annotations

from typing import Any

import numpy as np
import pybullet

from bench.row import at_least, at_most, stated
from bench.sim import six_fingers
from bench.sim.timing import timed_steps

STEPS = (0.005, 0.001)
SEGMENTS, PRESSURE = 15, 40e3
CLOSE, END = 0.8, 3.0  # [s]
LEAST_CONTACTS = 100
STILL = 5.0  # [mm] that the cylinder may move in the last second


def close_hard(step: float) -> tuple[float, list[int], float]:
    """Real-time factor, contact points in every tenth step, way [m] of the cylinder in the last
    second; raises RuntimeError when it diverges.
    """
    simulation = six_fingers.build(SEGMENTS, step)
    counts, places = [], []
    try:
        mass = six_fingers.closed_mass(simulation, PRESSURE)
        with timed_steps() as times:
            while simulation.time < END:
                simulation.set_air_masses(mass * min(1.0, simulation.time / CLOSE))
                simulation.step()
                if simulation.steps % 10 == 0:
                    client = simulation.world.client
                    counts.append(len(pybullet.getContactPoints(physicsClientId=client)))
                if simulation.time > END - 1.0:
                    places.append(simulation.object_pose()[0])
        way = float(np.linalg.norm(np.ptp(places, axis=0)))
        return times.factor(step), counts, way
    finally:
        simulation.close()


def rows(small: bool) -> list[dict[str, Any]]:
    """Contacts, whether they stay calm, and the real-time factor."""
    found = []
    for step in STEPS[: 1 if small else None]:
        factor, counts, way = close_hard(step)
        name = f"six fingers closed hard, {6 * SEGMENTS} segments, {1e3 * step:g} ms"
        found += [
            at_least(f"{name}: contact points, most", max(counts), "", LEAST_CONTACTS),
            stated(
                f"{name}: contact points, mean of the second half",
                float(np.mean(counts[len(counts) // 2 :])),
                "",
            ),
            at_most(f"{name}: the cylinder moves in 1 s", 1e3 * way, "mm", STILL),
            stated(f"{name}: real-time factor", factor, ""),
        ]
    return found
