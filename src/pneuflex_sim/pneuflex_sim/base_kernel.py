"""Pushing the bases of a hand's bodies along with the wrist, and reading the hand's load from their
velocities.
"""

from __future__ import annotations

import numpy as np

from pneuflex_sim.spatial import cross, quaternion_product
from pneuflex_sim.wrist import advance_wrist
from softhand_model.compiled import compiled


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
def place_bases(position, orientation, mounts, places, turns):
    """Poses (b, 3) [m] and (b, 4) of the mounts on a wrist at this pose."""
    for b in range(len(places)):
        rotate(orientation, mounts[0][b], places[b])
        for k in range(3):
            places[b, k] += position[k]
        quaternion_product(orientation, mounts[1][b], turns[b])


@compiled
def feel_load(step, velocity, pushed, resistance, places, weight, wrist_position, force, torque):
    """Wrench of the hand on the wrist from what the bases' velocities (b, 2, 3) gained on the push.

    `resistance` is (mass, inertia) of a base; `weight` (2, 3) is the wrench of the resting hand's
    weight on the wrist, which the arm carries.
    """
    lever, arm, gained = np.empty(3), np.empty(3), np.empty(3)
    for k in range(3):
        force[k], torque[k] = -weight[0, k], -weight[1, k]
    for b in range(len(places)):
        for k in range(3):
            arm[k] = places[b, k] - wrist_position[k]
            gained[k] = (velocity[b, 0, k] - pushed[b, 0, k]) * resistance[0] / step
        cross(arm, gained, lever)
        for k in range(3):
            force[k] += gained[k]
            turning = (velocity[b, 1, k] - pushed[b, 1, k]) * resistance[1] / step
            torque[k] += lever[k] + turning


@compiled
def push_bases(step, resistance, lift, poses, next_poses, velocity, pushed, push):
    """Forces and torques (b, 2, 3) that bring the bases from one pose to the next within a step.

    `velocity` (b, 2, 3) is what the bases have, `pushed` what they should have had: the difference
    has moved them, and that is made up for. `pushed` becomes the velocity to reach; `lift` [m/s2]
    holds a base against gravity.
    """
    inverse, change = np.empty(4), np.empty(4)
    for b in range(len(pushed)):
        for k in range(3):
            inverse[k] = -poses[1][b, k]
        inverse[3] = poses[1][b, 3]
        quaternion_product(next_poses[1][b], inverse, change)
        sign = 2.0 if change[3] >= 0 else -2.0
        for k in range(3):
            way = next_poses[0][b, k] - poses[0][b, k]
            for part in range(2):
                moved = velocity[b, part, k] - pushed[b, part, k]
                pushed[b, part, k] = (way if part == 0 else sign * change[k]) / step - moved
                gain = (pushed[b, part, k] - velocity[b, part, k]) / step
                push[b, part, k] = resistance[part] * gain
        push[b, 0, 2] += resistance[0] * lift


@compiled
def carry_bases(
    step,
    resistance,
    lift,
    mount_places,
    mount_turns,
    places,
    turns,
    velocity,
    pushed,
    hand_weight,
    center_of_mass,
    translation,
    rotation,
    target_position,
    target_orientation,
    force,
    torque,
    position,
    orientation,
    speed,
    spin,
    push,
):
    """One step of wrist and bases: feel the load, advance the wrist under it, find the push.

    places (b, 3) [m] and turns (b, 4) are the bases' poses, and become those to reach;
    `hand_weight` [N] acts at `center_of_mass` (3,) of the resting hand in the wrist frame. push
    (b, 3, 3) becomes force, torque and the place where they act.
    """
    weight, arm = np.zeros((2, 3)), np.empty(3)
    weight[0, 2] = -hand_weight
    rotate(orientation, center_of_mass, arm)
    cross(arm, weight[0], weight[1])
    feel_load(step, velocity, pushed, resistance, places, weight, position, force, torque)
    state = (position, orientation, speed, spin)
    target = (target_position, target_orientation)
    advance_wrist(step, translation, rotation, target, (force, torque), state)
    next_places, next_turns = np.empty_like(places), np.empty_like(turns)
    place_bases(position, orientation, (mount_places, mount_turns), next_places, next_turns)
    poses, next_poses = (places, turns), (next_places, next_turns)
    push_bases(step, resistance, lift, poses, next_poses, velocity, pushed, push)
    for b in range(len(places)):
        for k in range(3):
            push[b, 2, k] = places[b, k]
    places[:] = next_places
    turns[:] = next_turns
