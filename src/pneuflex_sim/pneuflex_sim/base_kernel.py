"""Pushing the bases of a hand's bodies along with the wrist, and reading the hand's load from their
velocities.
"""

from __future__ import annotations

import numpy as np

from pneuflex_sim.spatial import conjugate, cross, minus, plus, quaternion_product, write
from pneuflex_sim.wrist import advance_wrist
from softhand_model.compiled import compiled


@compiled
def rotate(q, vector):
    """The vector (3,) turned by the unit quaternion `q`."""
    half = cross(q, vector)
    first = (2 * half[0], 2 * half[1], 2 * half[2])
    second = cross(q, first)
    return (
        vector[0] + q[3] * first[0] + second[0],
        vector[1] + q[3] * first[1] + second[1],
        vector[2] + q[3] * first[2] + second[2],
    )


@compiled
def place_bases(position, orientation, mount_places, mount_turns, places, turns):
    """Poses (b, 3) [m] and (b, 4) of the mounts on a wrist at this pose."""
    for b in range(len(places)):
        turn = quaternion_product(orientation, mount_turns[b])
        write(plus(rotate(orientation, mount_places[b]), position), places[b])
        turns[b, 0], turns[b, 1], turns[b, 2], turns[b, 3] = turn


@compiled
def feel_load(step, velocity, pushed, resistance, places, weight, wrist_position, force, torque):
    """Wrench of the hand on the wrist from what the bases' velocities (b, 2, 3) gained on the push.

    `resistance` is (mass, inertia) of a base; `weight` is the force and the torque of the resting
    hand's weight on the wrist, which the arm carries.
    """
    for k in range(3):
        force[k], torque[k] = -weight[0][k], -weight[1][k]
    for b in range(len(places)):
        pull = _gained(step, velocity[b, 0], pushed[b, 0], resistance[0])
        turning = _gained(step, velocity[b, 1], pushed[b, 1], resistance[1])
        lever = cross(minus(places[b], wrist_position), pull)
        for k in range(3):
            force[k] += pull[k]
            torque[k] += lever[k] + turning[k]


@compiled
def _gained(step, velocity, pushed, resistance):
    """Force or torque that has changed a base's velocity against what it was pushed to."""
    gain = minus(velocity, pushed)
    return gain[0] * resistance / step, gain[1] * resistance / step, gain[2] * resistance / step


@compiled
def push_bases(
    step, resistance, lift, places, turns, next_places, next_turns, velocity, pushed, push
):
    """Forces and torques (b, 2, 3) that bring the bases from one pose to the next within a step.

    `velocity` (b, 2, 3) is what the bases have, `pushed` what they should have had: the difference
    has moved them, and that is made up for. `pushed` becomes the velocity to reach; `lift` [m/s2]
    holds a base against gravity.
    """
    for b in range(len(pushed)):
        change = quaternion_product(next_turns[b], conjugate(turns[b]))
        sign = 2.0 if change[3] >= 0 else -2.0
        for k in range(3):
            way = next_places[b, k] - places[b, k]
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
    down = (0.0, 0.0, -hand_weight)
    weight = (down, cross(rotate(orientation, center_of_mass), down))
    feel_load(step, velocity, pushed, resistance, places, weight, position, force, torque)
    state = (position, orientation, speed, spin)
    target = (target_position, target_orientation)
    advance_wrist(step, translation, rotation, target, (force, torque), state)
    next_places, next_turns = np.empty_like(places), np.empty_like(turns)
    place_bases(position, orientation, mount_places, mount_turns, next_places, next_turns)
    push_bases(
        step, resistance, lift, places, turns, next_places, next_turns, velocity, pushed, push
    )
    for b in range(len(places)):
        for k in range(3):
            push[b, 2, k] = places[b, k]
    places[:] = next_places
    turns[:] = next_turns
