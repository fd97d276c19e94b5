"""Shape of a hand from its joint orientations: tips and angles, without PyBullet."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from pneuflex_sim.chain_kernel import place_joints
from pneuflex_sim.layout import HandLayout

Array = NDArray[np.float64]


class HandShape:
    """Forward kinematics of a layout."""

    def __init__(self, layout: HandLayout) -> None:
        self.layout = layout
        n = len(layout.mass)
        self._inertia = np.ones((n, 3))

    def frames(self, q: Array) -> tuple[Array, Array, Array]:
        """Positions (n, 3) [m] and rotation matrices (n, 3, 3) of the joints, centres of mass (n,
        3), in the wrist frame.
        """
        layout, n = self.layout, len(q)
        frame, arm, center = np.empty((n, 3, 3)), np.empty((n, 3)), np.empty((n, 3))
        scratch, position = np.empty((n, 3, 3)), np.empty((n, 3))
        for body in layout.bodies:
            first, last = body.joints.start, body.joints.stop
            place_joints(
                first,
                last,
                q,
                layout.offset,
                layout.center,
                self._inertia,
                frame,
                arm,
                center,
                scratch,
            )
            turn = Rotation.from_quat(body.orientation).as_matrix()
            position[first:last] = np.cumsum(arm[first:last], axis=0) @ turn.T + body.position
            frame[first:last] = turn @ frame[first:last]
            center[first:last] = center[first:last] @ turn.T + position[first:last]
        return position, frame, center

    def fingertips(self, q: Array) -> dict[str, tuple[Array, Array]]:
        """Position [m] and quaternion of each fingertip in the wrist frame, in the order of the
        hand's `tips`.
        """
        position, frame, _ = self.frames(q)
        tips = {}
        for name in self.layout.description.tips:
            last = self.layout.chain_joints[name].stop - 1
            turn = frame[last]
            tips[name] = (
                position[last] + turn @ self.layout.chain_tips[name],
                Rotation.from_matrix(turn).as_quat(),
            )
        return tips

    def tip_angles(self, bend: Array) -> dict[str, float]:
        """Angle of the tip of each actuator against its base [rad]: the sum of its joints' bends
        (n,), strut left out.
        """
        angles = {}
        for chain in self.layout.description.chains:
            joints = self.layout.chain_joints[chain.name]
            first = joints.start + (1 if chain.strut is not None else 0)
            angle = float(bend[first : joints.stop].sum())
            angles.update(dict.fromkeys(chain.actuators, angle))
        return angles

    def center_of_mass(self, q: Array) -> Array:
        """Centre of mass (3,) of the chains in the wrist frame [m]."""
        center = self.frames(q)[2]
        return self.layout.mass @ center / self.layout.mass.sum()
