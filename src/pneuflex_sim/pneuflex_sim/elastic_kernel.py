"""Torque of one joint's elastic spring, linear or of rubber.

Linear: the energy is e*K*e/2, e the rotation vector of the joint against its rest. Rubber (eq.
3.24) in bending: with u = 1 + s*bend the stretch of the top, moment k*(q(u) - q(u_rest))/(2*s), q =
u - u**-3, in place of k*e_y: 2*k of a straight joint, k/2 of one bent far.
"""

from __future__ import annotations

import math

from pneuflex_sim.spatial import cross
from softhand_model.compiled import compiled
from softhand_model.spring_model import LEAST_STRETCH

SMALL_ANGLE = 1e-2  # [rad], below which series stand for the rotation's Jacobian


@compiled
def rubber_stress(stretch):
    """`spring_model.rubber_stress` of one joint: elastic term and slope [-] at a stretch [-]."""
    least = max(stretch, LEAST_STRETCH)
    inverse = 1.0 / least
    cube = inverse * inverse * inverse
    slope = 1.0 + 3.0 * cube * inverse
    return least - cube + slope * (stretch - least), slope


@compiled
def elastic_torque(error, rest_bend, stiffness, stretching):
    """Torque (3,) [N m] of a joint's spring on its child, in the child's axes, at a rotation
    `error` (3,) [rad] from a rest bent by rest_bend [rad]; and factors on the stiffness in bending:
    of its tangent here and in the rest shape.

    It is minus the gradient of the energy: the transposed inverse of the rotation's right Jacobian
    times K*e, K*e - e x K*e/2 + c*e x (e x K*e).
    """
    bending, here, at_rest = stiffness[1] * error[1], 1.0, 1.0
    if stretching > 0.0:
        stress, here = rubber_stress(1.0 + stretching * (rest_bend + error[1]))
        rest_stress, at_rest = rubber_stress(1.0 + stretching * rest_bend)
        bending = stiffness[1] * (stress - rest_stress) / (2.0 * stretching)
        here, at_rest = 0.5 * here, 0.5 * at_rest
    square = error[0] * error[0] + error[1] * error[1] + error[2] * error[2]
    share = 1.0 / 12.0 + square / 720.0
    if square > SMALL_ANGLE * SMALL_ANGLE:
        half = 0.5 * math.sqrt(square)
        share = (1.0 - half / math.tan(half)) / square
    along = (stiffness[0] * error[0], bending, stiffness[2] * error[2])
    across = cross(error, along)
    again = cross(error, across)
    torque = (
        -along[0] + 0.5 * across[0] - share * again[0],
        -along[1] + 0.5 * across[1] - share * again[1],
        -along[2] + 0.5 * across[2] - share * again[2],
    )
    return torque, here, at_rest
