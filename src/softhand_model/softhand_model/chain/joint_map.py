"""From the free angles of an actuator's segments to the joints of its chain, also of parallel
actuators.

The arcs have radii r_i < r_o and rigid common cross sections on a line of radius r = (r_i + r_o)/2.
Per arc angle phi the line bends by b and twists by t. The fibre of an arc runs r_j an angle and
tilts by +-(gap/2)*t/r_j against the line, so the arc bends by b + s_j*t', s_j = +-(gap/2)/r_j,
and both arcs twist by t. With free bends b_j = kappa_j*r_j, stiffness k_j = B_j/r_j in bending and
c_j in twist (equal to k_j as long as nothing else is known, see `joint_stiffness`), the rest shape
minimises

    integral of sum_j k_j*(b + s_j*t' - b_j)**2 + (c_i + c_o)*t**2,    t = 0 at the base.

So b is the mean of the arcs' bends weighted by k_j, and the twist obeys t'' = mu**2*t where the
difference D = b_o - b_i is constant, with S*t' = D at the tip, S = s_o - s_i and
mu = sqrt((k_i + k_o)*(c_i + c_o)/(k_i*k_o))/S. No difference, no twist: by the design rule (3.32)
that is kappa ~ 1/r at equal pressure, the rule by which the palm's walls were chosen
(d_o/d_i = r_o/r_i). The thesis says no more than that a pressure difference twists the palm; the
model is ours.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from softhand_common.numerics.arrays import Array
from softhand_common.numerics.rotations import rotate
from softhand_model.chain.segments import BEND_AXIS, SegmentChain
from softhand_model.hand.actuator import Actuator
from softhand_model.hand.hand import ChainDescription
from softhand_model.hand.joint_stiffness import THESIS, SpringModel

ARC_GAUSS_POINTS = 6


@dataclass(frozen=True)
class ParallelArcs:
    """Inner and outer arc, in this order.

    radii (2,) [m]. weights (2,) [-]: of their bends in the mean. angle [rad]: of both arcs. side:
    +1 if the arcs curve towards +y of the chain, -1 towards -y. decay: mu of the module.
    """

    radii: Array
    weights: Array
    angle: float
    side: int
    decay: float

    @property
    def tilt(self) -> Array:
        """s_i and s_o (2,) [-] of the module: bend of the two fibres per change of the twist with
        the arc angle.
        """
        gap = self.radii[1] - self.radii[0]
        return self.side * np.array([-0.5, 0.5]) * gap / self.radii

    def twist_rate(self, at: Array, start: Array, stop: Array) -> Array:
        """Twist rate t [-] at angles `at` [rad] for b_o - b_i = 1 between `start` and `stop`."""
        tilt = self.tilt
        return (self._green(at, stop) - self._green(at, start)) / (tilt[1] - tilt[0])

    def _green(self, at: Array, source: Array) -> Array:
        """Solution of mu**2*t - t'' = delta(source), with t = 0 at the base, t' = 0 at the tip."""
        near, far = np.minimum(at, source), np.maximum(at, source)
        mu, end = self.decay, self.angle
        return np.sinh(mu * near) * np.cosh(mu * (end - far)) / (mu * np.cosh(mu * end))


def parallel_arcs(
    inner: Actuator, outer: Actuator, side: int, springs: SpringModel = THESIS
) -> ParallelArcs:
    """The pair of two arcs with uniform sections. side: as in `ParallelArcs`."""
    radii = np.array([inner.arc_radius or 0.0, outer.arc_radius or 0.0])
    whole = np.array([springs.stiffness(arc, 1)[0] * arc.length for arc in (inner, outer)])
    _, bending, twist = (whole / radii[:, None]).T
    span = (radii[1] - radii[0]) / 2.0 * np.sum(1.0 / radii)
    decay = np.sqrt(bending.sum() * twist.sum() / bending.prod()) / span
    return ParallelArcs(radii, bending / bending.sum(), inner.arc_angle or 0.0, side, float(decay))


def bend_and_twist(arcs: ParallelArcs, segments: int) -> tuple[Array, Array]:
    """(matrices for the bend, matrices for the twist), each (2, segments, segments), one matrix per
    arc.

    They map the free angles [rad] of the segments of an arc to its contribution to the bend, or the
    twist, of each segment of the middle line [rad].
    """
    edges = np.linspace(0.0, arcs.angle, segments + 1)
    step = arcs.angle / segments
    start, stop = edges[:-1], edges[1:]
    at_edges = arcs.twist_rate(edges[:, None], start, stop) / step
    points, weights = np.polynomial.legendre.leggauss(ARC_GAUSS_POINTS)
    inside = (start[:, None] + step / 2.0 * (points + 1.0))[..., None]
    twist = np.einsum("p,ipk->ik", weights / 2.0, arcs.twist_rate(inside, start, stop))
    bend = -float(arcs.weights @ arcs.tilt) * np.diff(at_edges, axis=0)
    signs = np.array([-1.0, 1.0])[:, None, None]
    own = arcs.weights[:, None, None] * np.eye(segments)
    return own + signs * bend, signs * twist


def angle_maps(
    description: ChainDescription, chain: SegmentChain, segments: int, springs: SpringModel = THESIS
) -> list[Array]:
    """Matrix (3*n, segments) of each actuator, which maps angles of its segments to rotation
    vectors of the n joints.
    """
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
    stiffness = np.array([THESIS.stiffness(part, segments)[:, BEND_AXIS] for part in parts])
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

    The volume follows the rotation about the axis in the middle of the segment; the joint of an arc
    turns about it with the cosine of the angle between the axes.
    """
    gains = np.zeros((len(description.actuators), len(chain.mass)))
    cosine = rotate(chain.axes[-1], [0.0, 1.0, 0.0])[1]
    for row, part in zip(gains, description.actuators.values(), strict=True):
        x, weight = part.segment_quadrature(segments)
        mean = np.sum(weight * part.chamber_volume_gain(x), axis=1) * segments / part.length
        row[-segments:] = mean / cosine
    return gains
