"""Air and hand act on each other: chamber volumes from the shape, rest shape and gas stiffness from
the pressures.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pneuflex_sim.hand.layout import HandLayout
from softhand_model.gas import GAS_CONSTANT
from softhand_model.numerics.compiled import compiled

Array = NDArray[np.float64]

LEAST_VOLUME = 0.2  # of a chamber bent the wrong way, as a share of that at rest
BEND = 1  # index of the bending axis (y) in joint rotations


class AirCoupling:
    """Chambers of a hand grouped by channel; channels in the order of the hand's YAML, joints in
    that of the layout.

    rest_volumes (channels,) [m3]; volume_gain (channels, n) [m3/rad]: with each joint's bend.
    """

    def __init__(self, layout: HandLayout) -> None:
        channels, n = len(layout.description.channels), len(layout.mass)
        self.layout = layout
        self.rest_volumes = np.zeros(channels)
        self.volume_gain = np.zeros((channels, n))
        self._members: list[tuple[str, slice, NDArray[np.int64]]] = []
        for chain in layout.description.chains:
            joints, model = layout.chain_joints[chain.name], layout.models[chain.name]
            of_channel = np.array([layout.description.channel_of(name) for name in chain.actuators])
            np.add.at(
                self.rest_volumes, of_channel, model.volume(np.zeros(joints.stop - joints.start))
            )
            for row, channel in enumerate(of_channel):
                self.volume_gain[channel, joints] += model.volume_gain[row]
            self._members.append((chain.name, joints, of_channel))
        self._total_gain = self.volume_gain.sum(axis=1)
        self.by_tables = all(layout.models[name].rest_tables for name, _, _ in self._members)
        self._tables = self._stack_tables()
        self.actuated = (np.zeros((n, 3)), np.zeros((n, 3)))  # bend and gas stiffness of a step

    def _stack_tables(self) -> tuple[Array, ...]:
        """Rest tables of all actuators, without effects, for the kernels."""
        found = [
            (table, channel, joints.start)
            for name, joints, of_channel in self._members
            for table, channel in zip(self.layout.models[name].base_tables, of_channel, strict=True)
        ]
        tables, channels, starts = zip(*found, strict=True)
        widths = np.array([table.cubic.shape[2] for table in tables])
        cubic = np.zeros((len(tables), *tables[0].cubic.shape[:2], widths.max()))
        for row, table in enumerate(tables):
            cubic[row, :, :, : widths[row]] = table.cubic
        steps = np.array([table.step for table in tables])
        return np.array(channels), steps, cubic, np.array(starts), widths

    def volumes(self, rotations: Array) -> Array:
        """Volume of each channel [m3] for the joint rotations (n, 3) against rest [rad]."""
        found = np.empty_like(self.rest_volumes)
        chamber_volumes(self.rest_volumes, self.volume_gain, rotations, found)
        return found

    def imposed_pressures(
        self, masses: Array, ambient: float, temperature: float, rotations: Array
    ) -> tuple[Array, Array]:
        """Absolute pressures [Pa] and volumes [m3] of the channels when they hold these masses of
        air [kg above the fill at rest and ambient].
        """
        volumes, pressures = np.empty_like(masses), np.empty_like(masses)
        chamber_volumes(self.rest_volumes, self.volume_gain, rotations, volumes)
        heat = GAS_CONSTANT * temperature
        enclosed_pressures(masses, heat, ambient, self.rest_volumes, volumes, pressures)
        return pressures, volumes

    def arrays(self, volumes: Array) -> tuple[Array, ...]:
        """What `hand_kernel` calls air."""
        return (volumes, self._total_gain, *self._tables)

    def rest_bend(
        self, step: float, pressures: Array, rotations: Array, temperature: float
    ) -> Array:
        """Rotation (n, 3) [rad] that the gauge pressures [Pa] of the channels add to the rest."""
        if not self.by_tables:
            self.bend_by_models(step, pressures, rotations, temperature)
            return self.actuated[0].copy()
        bend, gas = np.zeros_like(rotations), np.zeros_like(rotations)
        drop = np.zeros_like(pressures)
        act_on_joints(pressures, drop, True, *self._tables, self.layout.stiffness, bend, gas)
        return bend

    def bend_by_models(
        self, step: float, pressures: Array, rotations: Array, temperature: float
    ) -> None:
        """Advance effects by a step [s], and put the rest shape that they leave into `actuated`."""
        for name, joints, of_channel in self._members:
            self.actuated[0][joints] = self.layout.models[name].step(
                step, pressures[of_channel], rotations[joints], temperature
            )

    def gas_stiffness(self, pressures: Array, pressures_abs: Array, volumes: Array) -> Array:
        """Stiffness (n, 3) [N m/rad] that enclosed air adds to each joint while all joints of its
        channel bend alike.

        dp = -p_abs/V*dV (isothermal), dV = sum of dV/dtheta over the channel, torque =
        -k*(dtheta_rest/dp)*dp. The true matrix is a dyad; its row sums on the diagonal are exact
        for that motion and bound it for any other, so they keep the implicit step stable. They act
        only on the motion within a step: statics do not depend on them.
        """
        bend, gas = (np.zeros_like(array) for array in self.actuated)
        drop = pressures_abs / volumes * self._total_gain
        act_on_joints(pressures, drop, False, *self._tables, self.layout.stiffness, bend, gas)
        return gas


@compiled
def chamber_volumes(rest_volumes, gain, rotations, out):
    """Volumes (channels,) [m3] for the joint rotations (n, 3) [rad]; `gain` (channels, n)."""
    for channel in range(len(out)):
        volume = rest_volumes[channel]
        for i in range(gain.shape[1]):
            volume += gain[channel, i] * rotations[i, BEND]
        out[channel] = max(volume, LEAST_VOLUME * rest_volumes[channel])


@compiled
def enclosed_pressures(masses, heat, ambient, rest_volumes, volumes, out):
    """Absolute pressures (channels,) [Pa] of masses [kg above rest] with R_s T = heat [J/kg]."""
    for channel in range(len(out)):
        content = ambient * rest_volumes[channel] + masses[channel] * heat
        out[channel] = content / volumes[channel]


@compiled
def act_on_joints(
    pressures, drop, with_bend, channel, step, cubic, start, width, stiffness, bend, gas
):
    """Add to `gas` (n, 3) [N m/rad] the slopes of all actuators' cubics at their channels'
    pressures [Pa] times `drop` [Pa/rad] of the channel and the stiffness; and make `bend` (n, 3)
    [rad] the sum of the cubics, if asked to.
    """
    if with_bend:
        bend[:] = 0.0
    for actuator in range(len(channel)):
        relative = max(pressures[channel[actuator]], 0.0) / step[actuator]
        index = min(int(relative), cubic.shape[1] - 1)
        t = relative - index
        fall = drop[channel[actuator]] / step[actuator]
        for k in range(width[actuator]):
            c, joint, axis = cubic[actuator, index], start[actuator] + k // 3, k % 3
            if with_bend:
                bend[joint, axis] += c[0, k] + t * (c[1, k] + t * (c[2, k] + t * c[3, k]))
            if axis == BEND:
                slope = c[1, k] + t * (2.0 * c[2, k] + t * 3.0 * c[3, k])
                gas[joint, axis] += fall * slope * stiffness[joint, axis]
