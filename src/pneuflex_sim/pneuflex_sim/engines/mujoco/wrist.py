"""The wrist in MuJoCo: a free body with the arm's mass and inertia, driven by the control law of
the arm. Any further change of its velocity is attributed to the load of the hand.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pneuflex_sim.hand.driven_bases import HandWeight
from pneuflex_sim.hand.wrist import Arm, WristState, arm_wrench
from softhand_common.numerics.compiled import compiled
from softhand_model.dynamics.spatial import conjugate, cross, rotate

Array = NDArray[np.float64]


@compiled
def push_wrist(
    step: float, arm: Arm, weight: HandWeight, wrist: WristState, push: Array, applied: Array
) -> None:
    """Fill the arm's push (2, 3) [N, N m] for a step [s], and the forces on the six degrees of
    freedom of the wrist, which also bear the weight of the resting hand.
    """
    arm_wrench(step, arm, wrist, push)
    up = (0.0, 0.0, weight.force)
    about = cross(rotate(wrist.orientation, weight.center), up)
    own = rotate(
        conjugate(wrist.orientation),
        (push[1, 0] + about[0], push[1, 1] + about[1], push[1, 2] + about[2]),
    )
    for k in range(3):
        applied[k] = push[0, k] + up[k]
        applied[3 + k] = own[k]


@compiled
def read_wrist(
    step: float, arm: Arm, wrist: WristState, push: Array, position: Array, velocity: Array
) -> None:
    """Take the pose from a free joint's `position` (7,) and the speeds from its `velocity` (6,),
    and compute the load on the wrist: what changed its speeds in this step besides the push (2, 3).
    """
    for k in range(3):
        wrist.position[k] = position[k]
        wrist.orientation[k] = position[4 + k]
    wrist.orientation[3] = position[3]
    spin = rotate(wrist.orientation, (velocity[3], velocity[4], velocity[5]))
    for k in range(3):
        gain, twist = velocity[k] - wrist.velocity[k], spin[k] - wrist.spin[k]
        wrist.force[k] = arm.translation.inertia * gain / step - push[0, k]
        wrist.torque[k] = arm.rotation.inertia * twist / step - push[1, k]
        wrist.velocity[k], wrist.spin[k] = velocity[k], spin[k]
