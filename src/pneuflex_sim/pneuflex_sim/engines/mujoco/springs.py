"""The springs of a hand's joints in MuJoCo, set anew before every step.

MuJoCo's `discrete` integrator is implicit in linear springs together with the contacts. So each
joint gets the tangent of our spring as its stiffness, and a reference at which MuJoCo's torque is
ours: for a hinge at angle a, reference = a + torque/stiffness; for a ball joint at q, q turned by
torque/stiffness. Whatever the law, the statics are exact. The stiffness of enclosed air is left to
the pressures of the next step: it acts on a whole finger, and is stable as it is up to 50 ms.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pneuflex_sim.hand.air import RestTables, act_on_joints
from softhand_common.numerics.compiled import compiled
from softhand_model.dynamics.joint_springs import (
    STOP_ANGLE,
    STOP_SHARE,
    Actuation,
    beyond_stop,
    elastic_torque,
)
from softhand_model.dynamics.spatial import (
    Array,
    quaternion_of_rotation,
    quaternion_product,
    rotation_between,
    write,
)

IntArray = NDArray[np.int64]


class Places(NamedTuple):
    """Where MuJoCo's arrays hold the joints (n,): first index of their positions, of their speeds
    and of their springs; `is_ball` (n,), else three hinges y, x, z.
    """

    position: IntArray
    speed: IntArray
    spring: IntArray
    is_ball: NDArray[np.bool_]


class State(NamedTuple):
    """MuJoCo's positions and speeds of the joints, and the references and stiffnesses of its
    springs.
    """

    qpos: Array
    qvel: Array
    reference: Array
    stiffness: Array


@compiled
def turned(joint: int, places: Places, qpos: Array) -> tuple[float, float, float, float]:
    """Rotation of a joint from its rest without pressure, as a quaternion x, y, z, w."""
    at = places.position[joint]
    if places.is_ball[joint]:
        return qpos[at + 1], qpos[at + 2], qpos[at + 3], qpos[at]
    y, x, z = 0.5 * qpos[at], 0.5 * qpos[at + 1], 0.5 * qpos[at + 2]
    first = quaternion_product(
        (0.0, math.sin(y), 0.0, math.cos(y)), (math.sin(x), 0.0, 0.0, math.cos(x))
    )
    return quaternion_product(first, (0.0, 0.0, math.sin(z), math.cos(z)))


@compiled
def set_springs(
    by_tables: bool,
    pressures: Array,
    tables: RestTables,
    stiffness: Array,
    stretching: Array,
    actuation: Actuation,
    places: Places,
    engine: State,
) -> None:
    """Set the springs at gauge pressures (channels,) [Pa]; `stiffness` (n, 3) [N m/rad] and
    `stretching` (n,) [1/rad] as in `Springs`. Without `by_tables` the rest shape is already in
    `actuation`.
    """
    act_on_joints(pressures, np.zeros_like(pressures), by_tables, tables, stiffness, actuation)
    bend, torque, tangent = actuation.bend, np.empty(3), np.empty(3)
    for i in range(len(stiffness)):
        for k in range(3):
            bend[i, k] = min(max(bend[i, k], -STOP_ANGLE), STOP_ANGLE)
        q = turned(i, places, engine.qpos)
        target = quaternion_of_rotation(bend[i])
        error = rotation_between(target, q)
        found, here, _ = elastic_torque(error, bend[i, 1], stiffness[i], stretching[i])
        write(found, torque)
        for k in range(3):
            tangent[k] = stiffness[i, k] * (here if k == 1 else 1.0)
            over = beyond_stop(bend[i, k] + error[k])
            if over != 0.0:
                torque[k] -= STOP_SHARE * stiffness[i, k] * over
                tangent[k] += STOP_SHARE * stiffness[i, k]
        if places.is_ball[i]:
            _set_ball(i, q, torque, max(tangent[0], tangent[1], tangent[2]), places, engine)
        else:
            _set_hinges(i, torque, tangent, places, engine)


@compiled
def _set_ball(i, q, torque, stiffness, places, engine):  # type: ignore[no-untyped-def]
    """Reference and stiffness [N m/rad] of a ball joint at q with a torque (3,) [N m]."""
    share = 1.0 / stiffness
    ahead = quaternion_of_rotation((share * torque[0], share * torque[1], share * torque[2]))
    rest, at = quaternion_product(q, ahead), places.position[i]
    engine.reference[at] = rest[3]
    for k in range(3):
        engine.reference[at + 1 + k] = rest[k]
    engine.stiffness[places.spring[i]] = stiffness


@compiled
def _set_hinges(i, torque, tangent, places, engine):  # type: ignore[no-untyped-def]
    """References and stiffnesses of hinges about y, x, z with a torque (3,) [N m] about the child's
    axes.
    """
    at, spring = places.position[i], places.spring[i]
    x, z = engine.qpos[at + 1], engine.qpos[at + 2]
    about_x = math.cos(z) * torque[0] - math.sin(z) * torque[1]
    about_y = (
        math.cos(x) * (math.sin(z) * torque[0] + math.cos(z) * torque[1]) - math.sin(x) * torque[2]
    )
    for k in range(3):
        axis = (1, 0, 2)[k]
        about = (about_y, about_x, torque[2])[k]
        engine.reference[at + k] = engine.qpos[at + k] + about / tangent[axis]
        engine.stiffness[spring + k] = tangent[axis]


@compiled
def read_joints(rest: Array, places: Places, engine: State, q: Array, v: Array) -> None:
    """Fill orientations q (n, 4) and speeds v (n, 3) [rad/s], in the axes of each child."""
    for i in range(len(rest)):
        against_rest = turned(i, places, engine.qpos)
        orientation = quaternion_product(rest[i], against_rest)
        for k in range(4):
            q[i, k] = orientation[k]
        at = places.speed[i]
        if places.is_ball[i]:
            for k in range(3):
                v[i, k] = engine.qvel[at + k]
            continue
        position = places.position[i]
        x, z = engine.qpos[position + 1], engine.qpos[position + 2]
        fast_y, fast_x, fast_z = engine.qvel[at], engine.qvel[at + 1], engine.qvel[at + 2]
        v[i, 0] = math.cos(z) * fast_x + math.cos(x) * math.sin(z) * fast_y
        v[i, 1] = math.cos(x) * math.cos(z) * fast_y - math.sin(z) * fast_x
        v[i, 2] = fast_z - math.sin(x) * fast_y
