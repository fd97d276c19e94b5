"""Pushing the bases of a hand's bodies along with the wrist, and reading the hand's load from their
velocities.
"""

from __future__ import annotations

import numpy as np

from pneuflex_sim.compiled import compiled
from pneuflex_sim.spatial import cross, quaternion_product


@compiled
def rotate(q, vector, out):
    """Write `vector` (3,) turned by the unit quaternion `q` into `out`."""
    first, second = np.empty(3), np.empty(3)
    cross(q, vector, first)
    for k in range(3):
        first[k] = 2 * first[k]
    cross(q, first, second)
    for k in range(3):
        out[k] = vector[k] + q[3] * first[k] + second[k]


@compiled
def place_bases(position, orientation, mount_position, mount_orientation, places, turns):
    """Poses (b, 3) [m] and (b, 4) of the mounts on a wrist at this pose."""
    for b in range(len(mount_position)):
        rotate(orientation, mount_position[b], places[b])
        for k in range(3):
            places[b, k] += position[k]
        quaternion_product(orientation, mount_orientation[b], turns[b])


@compiled
def velocities_between(step, places, turns, next_places, next_turns, drift, velocity):
    """Velocity (b, 2, 3), linear then spin, from one pose to the next within a step, making up for
    `drift` (b, 2, 3).
    """
    inverse, change = np.empty(4), np.empty(4)
    for b in range(len(places)):
        for k in range(3):
            velocity[b, 0, k] = (next_places[b, k] - places[b, k] - drift[b, 0, k]) / step
            inverse[k] = -turns[b, k]
        inverse[3] = turns[b, 3]
        quaternion_product(next_turns[b], inverse, change)
        sign = 2.0 if change[3] >= 0 else -2.0
        for k in range(3):
            velocity[b, 1, k] = (sign * change[k] - drift[b, 1, k]) / step


@compiled
def total_wrench(load, places, wrist_position, force, torque):
    """Sum of the loads (b, 2, 3) [N, N m] at the bases, referred to the wrist."""
    lever, arm = np.empty(3), np.empty(3)
    force[:] = 0.0
    torque[:] = 0.0
    for b in range(len(load)):
        for k in range(3):
            arm[k] = places[b, k] - wrist_position[k]
        cross(arm, load[b, 0], lever)
        for k in range(3):
            force[k] += load[b, 0, k]
            torque[k] += load[b, 1, k] + lever[k]
