"""From the free angles of an actuator's segments to the joints of its chain."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from softhand_model.actuator import Actuator
from softhand_model.hands import ChainDescription
from softhand_model.parallel_arcs import bend_and_twist, parallel_arcs
from softhand_model.rotation import rotate
from softhand_model.segments import SegmentChain
from softhand_model.spring_model import THESIS, SpringModel

Array = NDArray[np.float64]

BEND = 1  # index of the bending axis (y)


def spread_angles(
    description: ChainDescription,
    chain: SegmentChain,
    segments: int,
    springs: SpringModel = THESIS,
) -> list[Array]:
    """Matrix (3*n, segments) of each actuator, from segment angles to joint rotation vectors."""
    parts = list(description.actuators.values())
    if description.turn and len(parts) == 2:
        bends, twists = bend_and_twist(
            parallel_arcs(parts[0], parts[1], description.turn, springs), segments
        )
    else:
        bends = np.array([np.diag(share) for share in _shares(parts, segments)])
        twists = np.zeros_like(bends)
    return [_onto_joints(chain, *shares) for shares in zip(bends, twists, strict=True)]


def _shares(parts: list[Actuator], segments: int) -> Array:
    """Weight (actuators, segments) [-] of each actuator's bend: its share of the stiffness.

    One passive layer bends all alike, so the sum of their moments B_j*(kappa - kappa_j) is 0.
    """
    stiffness = np.array([THESIS.stiffness(part, segments)[:, BEND] for part in parts])
    return stiffness / stiffness.sum(axis=0)


def _onto_joints(chain: SegmentChain, bend: Array, twist: Array) -> Array:
    """Bend about y and twist about z of the segments as rotation vectors in the links' frames."""
    joints, segments = len(chain.mass), len(bend)
    matrix = np.zeros((joints, 3, segments))
    for joint, (bend_row, twist_row) in enumerate(zip(bend, twist, strict=True), joints - segments):
        vectors = np.stack([np.zeros(segments), bend_row, twist_row], axis=1)
        matrix[joint] = rotate(chain.axes[joint], vectors).T
    return matrix.reshape(3 * joints, segments)


def volume_gains(description: ChainDescription, chain: SegmentChain, segments: int) -> Array:
    """Change (actuators, n) [m3/rad] of each chamber's volume with the joints' rotation about y.

    The volume follows the rotation about the axis in the middle of the segment, of which an arc's
    link sees the cosine.
    """
    gains = np.zeros((len(description.actuators), len(chain.mass)))
    cosine = rotate(chain.axes[-1], [0.0, 1.0, 0.0])[1]
    for row, part in zip(gains, description.actuators.values(), strict=True):
        x, weight = part.segment_quadrature(segments)
        mean = np.sum(weight * part.chamber_volume_gain(x), axis=1) * segments / part.length
        row[-segments:] = mean / cosine
    return gains
