"""Coupling of air and hand: the shape determines the chamber volumes; the pressures determine rest
shape and gas stiffness.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from pneuflex_sim.hand.layout import HandLayout
from softhand_common.numerics.compiled import compiled
from softhand_model.dynamics.joint_springs import Actuation
from softhand_model.dynamics.spatial import Array, IntArray
from softhand_model.effects.hand import channel_lags, pressure_offsets, pressure_shares
from softhand_model.gas import GAS_CONSTANT

MIN_VOLUME_SHARE = 0.2  # of a chamber bent the wrong way, as a share of that at rest
BEND_AXIS = 1  # index of the bending axis (y) in joint rotations


class RestTables(NamedTuple):
    """Rest shape over pressure of all actuators, as piecewise cubics.

    Attributes:
        channel: (actuators,) index of the channel that feeds each actuator.
        feed: (actuators, channels) share of each channel's pressure that acts in each actuator.
        step: (actuators,) [Pa] between the pressures of a table.
        cubic: (actuators, intervals, 4, columns), coefficients, three columns per joint.
        first_joint: (actuators,) index of each actuator's first joint.
        columns: (actuators,) number of columns in use.
    """

    channel: IntArray
    feed: Array
    step: Array
    cubic: Array
    first_joint: IntArray
    columns: IntArray


class AirCoupling:
    """Chambers of a hand grouped by channel; channels in the order of the hand's YAML, joints in
    that of the layout.

    Attributes:
        rest_volumes: (channels,) [m3], without pressure.
        volume_gain: (channels, n) [m3/rad], growth of the volume with each joint's bend.
        total_gain: (channels,) [m3/rad], growth of the volume with an equal bend of all joints.
        lags: (channels,) [s], time constants with which the pressure in the actuators follows that
            of their channel.
        offsets: (channels,) [Pa], what sensors read without pressure: less acts in the actuators.
        by_tables: whether the rest shape follows from tables alone, without effects of the model.
        actuation: effect of the pressures of the present step on the joints.
    """

    def __init__(self, layout: HandLayout) -> None:
        hand, n = layout.description, len(layout.mass)
        self.layout = layout
        self._fed = {
            chain.name: np.array([hand.channel_of(name) for name in chain.actuators])
            for chain in hand.chains
        }
        effects = next(iter(layout.models.values())).model.effects
        shares = pressure_shares(hand, effects)
        self.lags = channel_lags(hand, effects)
        self.offsets = pressure_offsets(hand, effects)
        self._feed = dict(zip(hand.actuator_names, shares, strict=True))
        rest, gain = np.zeros(len(hand.channels)), np.zeros((len(hand.channels), n))
        for name, channels in self._fed.items():
            joints, model = layout.chain_joints[name], layout.models[name]
            np.add.at(rest, channels, model.volume(np.zeros(joints.stop - joints.start)))
            for row, channel in enumerate(channels):
                gain[channel, joints] += model.volume_gain[row]
        self.rest_volumes, self.volume_gain, self.total_gain = rest, gain, gain.sum(axis=1)
        self.by_tables = all(layout.models[name].rest_tables for name in self._fed)
        self.tables = self._stack_tables()
        self.actuation = Actuation(np.zeros((n, 3)), np.zeros((n, 3)))

    def _stack_tables(self) -> RestTables:
        """Rest tables of all actuators."""
        found = [
            (table, channel, self.layout.chain_joints[name].start)
            for name, channels in self._fed.items()
            for table, channel in zip(self.layout.models[name].base_tables, channels, strict=True)
        ]
        tables, channels, starts = zip(*found, strict=True)
        columns = np.array([table.cubic.shape[2] for table in tables])
        cubic = np.zeros((len(tables), *tables[0].cubic.shape[:2], columns.max()))
        for row, table in enumerate(tables):
            cubic[row, :, :, : columns[row]] = table.cubic
        steps = np.array([table.step for table in tables])
        feed = np.array(list(self._feed.values()))
        return RestTables(np.array(channels), feed, steps, cubic, np.array(starts), columns)

    def volumes(self, rotations: Array) -> Array:
        """Volume of each channel [m3] for the joint rotations (n, 3) against rest [rad]."""
        found = np.empty_like(self.rest_volumes)
        chamber_volumes(self.rest_volumes, self.volume_gain, rotations, found)
        return found

    def enclosed_air(
        self, masses: Array, ambient: float, temperature: float, rotations: Array
    ) -> tuple[Array, Array]:
        """Absolute pressures [Pa] and volumes [m3] of channels that hold these masses of air [kg
        above the fill at rest and ambient pressure].
        """
        volumes, pressures_abs = np.empty_like(masses), np.empty_like(masses)
        chamber_volumes(self.rest_volumes, self.volume_gain, rotations, volumes)
        heat = GAS_CONSTANT * temperature
        enclosed_pressures_abs(masses, heat, ambient, self.rest_volumes, volumes, pressures_abs)
        return pressures_abs, volumes

    def acting(self, step: float, before: Array, pressures_abs: Array) -> Array:
        """Absolute pressures (channels,) [Pa] in the actuators after a step [s], from those at its
        start, `before`, and the absolute pressures of the channels, less `offsets`, which they
        follow with `lags`.
        """
        felt = pressures_abs - self.offsets
        if not self.lags.any():
            return np.asarray(felt)
        share = np.where(self.lags > 0.0, np.exp(-step / np.maximum(self.lags, 1e-9)), 0.0)
        return np.asarray(felt + share * (before - felt))

    def masses(
        self, pressures_abs: Array, ambient: float, temperature: float, rotations: Array
    ) -> Array:
        """Air [kg above the fill at rest and ambient] that the channels hold at these absolute
        pressures [Pa]: the inverse of `enclosed_air`.
        """
        heat = GAS_CONSTANT * temperature
        content = pressures_abs * self.volumes(rotations)
        return (content - ambient * self.rest_volumes) / heat

    def rest_bend(
        self, step: float, pressures: Array, rotations: Array, temperature: float
    ) -> Array:
        """Rotation (n, 3) [rad] by which gauge pressures (channels,) [Pa] turn the rest shape of
        each joint. Effects of the model with memory advance by a step [s], at joint rotations
        (n, 3) [rad] and a temperature [K].
        """
        if not self.by_tables:
            self.bend_by_models(step, pressures, rotations, temperature)
            return self.actuation.bend.copy()
        found = Actuation(np.zeros_like(rotations), np.zeros_like(rotations))
        act_on_joints(
            pressures, np.zeros_like(pressures), True, self.tables, self.layout.stiffness, found
        )
        return found.bend

    def bend_by_models(
        self, step: float, pressures: Array, rotations: Array, temperature: float
    ) -> None:
        """Advance the effects of the model by a step [s] at gauge pressures (channels,) [Pa] and a
        temperature [K], and store the resulting rest shape in `actuation`.
        """
        for name in self._fed:
            joints, model = self.layout.chain_joints[name], self.layout.models[name]
            acting = np.array([self._feed[part] for part in model.description.actuators])
            self.actuation.bend[joints] = model.step(
                step, acting @ pressures, rotations[joints], temperature
            )


@compiled
def chamber_volumes(rest_volumes: Array, gain: Array, rotations: Array, volumes: Array) -> None:
    """Fill the volumes (channels,) [m3] for the joint rotations (n, 3) [rad]; `gain` (channels, n)
    [m3/rad].
    """
    for channel in range(len(volumes)):
        volume = rest_volumes[channel]
        for i in range(gain.shape[1]):
            volume += gain[channel, i] * rotations[i, BEND_AXIS]
        volumes[channel] = max(volume, MIN_VOLUME_SHARE * rest_volumes[channel])


@compiled
def enclosed_pressures_abs(
    masses: Array,
    heat: float,
    ambient: float,
    rest_volumes: Array,
    volumes: Array,
    pressures_abs: Array,
) -> None:
    """Fill the absolute pressures (channels,) [Pa] of air masses (channels,) [kg above rest] in
    `volumes` (channels,) [m3] behind closed valves; `heat` is R_s*T [J/kg].
    """
    for channel in range(len(volumes)):
        content = ambient * rest_volumes[channel] + masses[channel] * heat
        pressures_abs[channel] = content / volumes[channel]


@compiled
def act_on_joints(
    pressures: Array,
    drop: Array,
    with_bend: bool,
    tables: RestTables,
    stiffness: Array,
    actuation: Actuation,
) -> None:
    """Fill `actuation.gas`, the stiffness that the enclosed air adds to each joint while all joints
    of its channel bend alike, and, if `with_bend`, `actuation.bend`, the rest shape at the gauge
    pressures (channels,) [Pa].

    `drop` (channels,) [Pa/rad] is p_abs/V times the sum of dV/dtheta over the channel, the fall of
    the pressure with the bend (isothermal); torque = -k*(dtheta_rest/dp)*dp. The true stiffness
    matrix is a dyad. Its row sums on the diagonal are exact for an equal bend of all joints and an
    upper bound for any other motion, so they keep the implicit step stable. They act only on the
    motion within a step and do not change the statics.
    """
    bend, gas = actuation.bend, actuation.gas
    gas[:] = 0.0
    if with_bend:
        bend[:] = 0.0
    for actuator in range(len(tables.channel)):
        channel, step = tables.channel[actuator], tables.step[actuator]
        pressure = 0.0
        for other in range(len(pressures)):
            pressure += tables.feed[actuator, other] * pressures[other]
        relative = max(pressure, 0.0) / step
        index = min(int(relative), tables.cubic.shape[1] - 1)
        c, t, fall = tables.cubic[actuator, index], relative - index, drop[channel] / step
        for k in range(tables.columns[actuator]):
            joint, axis = tables.first_joint[actuator] + k // 3, k % 3
            if with_bend:
                bend[joint, axis] += c[0, k] + t * (c[1, k] + t * (c[2, k] + t * c[3, k]))
            if axis == BEND_AXIS:
                slope = c[1, k] + t * (2.0 * c[2, k] + t * 3.0 * c[3, k])
                gas[joint, axis] += fall * slope * stiffness[joint, axis]
