"""Air and hand act on each other: chamber volumes from the shape, rest shape and gas stiffness from
the pressures.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pneuflex_sim.layout import HandLayout
from softhand_model.compiled import compiled

Array = NDArray[np.float64]

LEAST_VOLUME = 0.2  # of a chamber bent the wrong way, as a share of that at rest
BEND = 1  # index of the bending axis (y) in joint rotations


class AirCoupling:
    """Chambers of a hand grouped by channel; channels in the order of the hand's YAML, joints in
    that of the layout.
    """

    def __init__(self, layout: HandLayout) -> None:
        channels, n = len(layout.description.channels), len(layout.mass)
        self.layout = layout
        self.rest_volumes = np.zeros(channels)
        self._volume_gain = np.zeros((channels, n))
        self._members: list[tuple[str, slice, NDArray[np.int64]]] = []
        for chain in layout.description.chains:
            joints, model = layout.chain_joints[chain.name], layout.models[chain.name]
            of_channel = np.array([layout.description.channel_of(name) for name in chain.actuators])
            np.add.at(
                self.rest_volumes, of_channel, model.volume(np.zeros(joints.stop - joints.start))
            )
            for row, channel in enumerate(of_channel):
                self._volume_gain[channel, joints] += model.volume_gain[row]
            self._members.append((chain.name, joints, of_channel))
        self._total_gain = self._volume_gain.sum(axis=1)
        self._tables = self._stack_tables()

    def _stack_tables(self) -> tuple[Array, ...] | None:
        """Rest tables of all actuators for `add_rest_rotations`; None with effects."""
        found = [
            (table, channel, joints.start)
            for name, joints, of_channel in self._members
            for table, channel in zip(
                self.layout.models[name].rest_tables, of_channel, strict=False
            )
        ]
        if len(found) < sum(len(of_channel) for _, _, of_channel in self._members):
            return None
        tables, channels, starts = zip(*found, strict=True)
        widths = np.array([table.cubic.shape[2] for table in tables])
        cubic = np.zeros((len(tables), *tables[0].cubic.shape[:2], widths.max()))
        for row, table in enumerate(tables):
            cubic[row, :, :, : widths[row]] = table.cubic
        steps = np.array([table.step for table in tables])
        return np.array(channels), steps, cubic, np.array(starts), widths

    def volumes(self, rotations: Array) -> Array:
        """Volume of each channel [m3] for the joint rotations (n, 3) against rest [rad]."""
        volumes = self.rest_volumes + self._volume_gain @ rotations[:, BEND]
        return np.maximum(volumes, LEAST_VOLUME * self.rest_volumes)

    def rest_bend(
        self, step: float, pressures: Array, rotations: Array, temperature: float
    ) -> Array:
        """Rotation (n, 3) [rad] that the gauge pressures [Pa] of the channels add to the rest."""
        bend = np.zeros_like(rotations)
        if self._tables is not None:
            add_rest_rotations(pressures, *self._tables, bend)
            return bend
        for name, joints, of_channel in self._members:
            bend[joints] = self.layout.models[name].step(
                step, pressures[of_channel], rotations[joints], temperature
            )
        return bend

    def gas_stiffness(self, pressures: Array, pressures_abs: Array, volumes: Array) -> Array:
        """Stiffness (n, 3) [N m/rad] that enclosed air adds to each joint while all joints of its
        channel bend alike.

        dp = -p_abs/V*dV (isothermal), dV = sum of dV/dtheta over the channel, torque =
        -k*(dtheta_rest/dp)*dp. The true matrix is a dyad; its row sums on the diagonal are exact
        for that motion and bound it for any other, so they keep the implicit step stable. They act
        only on the motion within a step: statics do not depend on them.
        """
        stiffness = np.zeros_like(self.layout.stiffness)
        pressure_drop = pressures_abs / volumes * self._total_gain
        for name, joints, of_channel in self._members:
            gain = self.layout.models[name].rest_gain(pressures[of_channel])
            stiffness[joints, BEND] = pressure_drop[of_channel] @ gain
        return stiffness * self.layout.stiffness


@compiled
def add_rest_rotations(pressures, channel, step, cubic, start, width, bend):
    """Add the cubics of all actuators at their channels' pressures [Pa] to `bend` (n, 3) [rad]."""
    for actuator in range(len(channel)):
        relative = max(pressures[channel[actuator]], 0.0) / step[actuator]
        index = min(int(relative), cubic.shape[1] - 1)
        t = relative - index
        for k in range(width[actuator]):
            c = cubic[actuator, index]
            value = c[0, k] + t * (c[1, k] + t * (c[2, k] + t * c[3, k]))
            bend[start[actuator] + k // 3, k % 3] += value
