"""From the free angles of an actuator's segments to the joints of its chain: bend, and the twist of
parallel arcs.

Two parallel arcs of radii r_i < r_o share one line of radius r = (r_i + r_o)/2 and rigid cross
sections. Per arc angle phi, let the line bend by b and twist by t. A fibre at the distance rho
outwards runs r_j = r + rho an angle and tilts by rho*t/r_j against the line, so it bends by b plus
the derivative of that tilt, clamped to no tilt at the base. Both arcs bend freely, beta_j =
integral of kappa_j*r_j, if

    b = (r_i*b_i + r_o*b_o)/(2*r),    |t| = r_i*r_o/(r*(r_o - r_i)) * (beta_o - beta_i).

Equal free bends give no twist: by the design rule (3.32) that is kappa ~ 1/r, the rule by which the
palm's walls were chosen (d_o/d_i = r_o/r_i). The thesis says no more than that unequal pressure
twists the palm; this is our reading.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from softhand_model.actuator import Actuator
from softhand_model.hands import ChainDescription
from softhand_model.rotation import rotate
from softhand_model.segments import SegmentChain, arc_angle, mean_radius

Array = NDArray[np.float64]


def spread_angles(description: ChainDescription, chain: SegmentChain, segments: int) -> list[Array]:
    """Matrix (3*n, segments) of each actuator that takes its segments' angles to the rotation
    vectors of the joints.
    """
    parts = list(description.actuators.values())
    joints = len(chain.mass)
    first = joints - segments
    matrices = []
    for part in parts:
        bend, twist = _bend_share(parts, part), _twist(parts, part, description.turn, segments)
        matrix = np.zeros((joints, 3, segments))
        for joint in range(segments):
            about = np.zeros((segments, 3))
            about[joint, 1] = bend
            about[:, 2] = twist[joint]
            matrix[first + joint] = rotate(chain.axes[first + joint], about).T
        matrices.append(matrix.reshape(3 * joints, segments))
    return matrices


def volume_gains(description: ChainDescription, chain: SegmentChain, segments: int) -> Array:
    """Change (actuators, n) [m3/rad] of each chamber's volume with the joints' rotation about their
    link's y.

    The volume follows the rotation about the axis in the middle of the segment, of which an arc's
    link sees the cosine.
    """
    gains = np.zeros((len(description.actuators), len(chain.mass)))
    for row, part in zip(gains, description.actuators.values(), strict=True):
        x, weight = part.segment_quadrature(segments)
        mean = np.sum(weight * part.chamber_volume_gain(x), axis=1) * segments / part.length
        row[-segments:] = mean / rotate(chain.axes[-1], [0.0, 1.0, 0.0])[1]
    return gains


def _bend_share(parts: list[Actuator], part: Actuator) -> float:
    """Share of an arc's angle in that of the line."""
    if len(parts) == 1:
        return 1.0
    return (part.arc_radius or 0.0) / (2.0 * mean_radius(parts))


def _twist(parts: list[Actuator], part: Actuator, turn: int, segments: int) -> Array:
    """Matrix (segments, segments): twist of each segment by an arc's segment angles.

    The twist rate grows with the angle bent so far: segments nearer to the base count fully, the
    own one by half.
    """
    if len(parts) == 1:
        return np.zeros((segments, segments))
    inner, outer = (p.arc_radius or 0.0 for p in parts)
    rate = turn * inner * outer / (mean_radius(parts) * (outer - inner))
    sign = 1.0 if part is parts[-1] else -1.0
    so_far = np.tri(segments, segments, -1) + np.eye(segments) / 2.0
    return sign * rate * arc_angle(parts) / segments * so_far
