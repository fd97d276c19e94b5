"""The simulated chain: spring joints whose rest orientation follows the pressure (5.1.3).

A simulation has a diagonal stiffness K. If effects change it to C*K, with a matrix C (3, 3) for
each joint, and e is the rotation of the joint from its rest, the rest is moved so that the springs
K cause the torque C*K*e.
"""

from __future__ import annotations

from collections.abc import Sequence
from copy import copy
from dataclasses import replace
from functools import cached_property

import numpy as np

from softhand_common.numerics.arrays import Array
from softhand_model.chain.free_response import (
    WITHOUT_EFFECTS,
    RestTable,
    SegmentResponse,
    angle_table,
    bends,
    tabulates,
)
from softhand_model.chain.joint_map import angle_maps, volume_gains
from softhand_model.chain.segments import (
    BEND_AXIS,
    LATERAL_AXIS,
    TWIST_AXIS,
    SegmentChain,
    cut_chain,
)
from softhand_model.effects import Effect
from softhand_model.effects.hand import modulus_factor, palm_factor, rest_bend, tip_mass
from softhand_model.effects.pipeline import StagedEffects
from softhand_model.gas import ROOM_TEMPERATURE
from softhand_model.hand.hand import ChainDescription
from softhand_model.model_file import Model


def moved_rest(rest: Array, actual: Array, factor: Array, coupling: Array) -> Array:
    """Rotation vectors (n, 3) [rad] of the rest orientation at which the original springs have the
    same torques as the changed springs.

    rest, actual (n, 3) [rad]: rotation vectors of the free and the actual joint. factor (n, 3) [-]:
    on the stiffness about each axis. coupling (n, 2) [-]: stiffness that couples lateral bending
    and twist, over that about x and about z. For springs that are not linear, or not equal about
    all axes, the result holds for small angles.

    >>> moved_rest(np.zeros((1, 3)), np.full((1, 3), 0.1), np.full((1, 3), 0.5), np.zeros((1, 2)))
    array([[0.05, 0.05, 0.05]])
    """
    if not coupling.any():
        # the axes of bend and error are the same as long as nothing turns sideways
        return actual + factor * (rest - actual)
    from scipy.spatial.transform import Rotation  # here, as it takes long to load

    turned = Rotation.from_rotvec(actual)
    away = (Rotation.from_rotvec(rest).inv() * turned).as_rotvec()
    pull = factor * away
    pull[:, LATERAL_AXIS] += coupling[:, 0] * away[:, TWIST_AXIS]
    pull[:, TWIST_AXIS] += coupling[:, 1] * away[:, LATERAL_AXIS]
    return np.asarray((turned * Rotation.from_rotvec(pull).inv()).as_rotvec(), float)


def discretise(description: ChainDescription, segments: int, model: Model) -> ChainModel:
    """Cut a chain into `segments` segments per actuator, under a model.

    Raises ValueError for fewer than one segment or a base other than `pneuflex`.

    >>> from softhand_model.hand.hand import load_hand
    >>> finger = discretise(load_hand("single_finger").chain("finger"), 5, Model())
    >>> finger.rest_rotation([31e3]).sum(axis=0).round(2).tolist()
    [0.0, 2.5, 0.0]
    """
    if segments < 1:
        raise ValueError(f"segments: expected at least 1, got {segments}")
    if model.base != "pneuflex":
        raise ValueError(f"model base: expected pneuflex for a simulated chain, got {model.base}")
    return ChainModel(description, segments, model)


class ChainModel:
    """A discretised chain under a model; pressures are gauge, one for each of its actuators.

    segments: the rigid links and joint springs. count: number of segments per actuator.
    """

    def __init__(self, description: ChainDescription, segments: int, model: Model) -> None:
        scale = model.modulus_scale()
        parts = {
            name: replace(
                actuator,
                shear_modulus=scale
                * modulus_factor(name, model.effects)
                * model.shear_modulus(actuator.shear_modulus),
            )
            for name, actuator in description.actuators.items()
        }
        self.description = replace(description, actuators=parts)
        cut = cut_chain(self.description, segments, model.springs)
        self.segments = _altered(cut, self.description, segments, model)
        self._shape = self.segments.offset.shape
        self._struts = self._shape[0] - segments  # joints that no actuator bends
        self._angle_maps = angle_maps(self.description, self.segments, segments, model.springs)
        self._stated = list(description.actuators.values())
        self._parts, self.count = list(parts.values()), segments
        self._act(model)

    def _act(self, model: Model) -> None:
        """Take the effects of a model on the rubber."""
        self.model = model
        self._responses = [
            SegmentResponse(part, self.count, model)
            for part in (self._parts if bends(model) and not tabulates(model) else ())
        ]
        self._staged = StagedEffects(model.effects)  # of which nothing with memory is asked

    def of_rubber(self, effects: Sequence[Effect]) -> ChainModel:
        """The chain with further effects on its rubber, and the same segments, which these do not
        change.
        """
        found = copy(self)
        found.__dict__.pop("_tables", None)
        found._act(replace(self.model, effects=(*self.model.effects, *effects)))
        return found

    @cached_property
    def _rest_volume(self) -> Array:
        return np.array([part.chamber_volume() + part.supply_volume for part in self._parts])

    @cached_property
    def volume_gain(self) -> Array:
        """Change (actuators, n) [m3/rad] of each chamber's volume with a joint's rotation about y.

        Constant, because the volume is linear in the curvature (eq. 3.17).
        """
        return volume_gains(self.description, self.segments, self.count)

    @cached_property
    def _tables(self) -> list[RestTable]:
        """Tables of the actuators."""
        model = self.model if tabulates(self.model) else WITHOUT_EFFECTS
        return [
            RestTable(part, self.count, onto_joints, model)
            for part, onto_joints in zip(self._parts, self._angle_maps, strict=True)
        ]

    @property
    def rest_tables(self) -> tuple[RestTable, ...]:
        """Tables, one per actuator, that add up to the result of `step`; empty if effects with
        memory, or effects on input or springs, act on the chain.
        """
        return () if self._responses else tuple(self._tables)

    @property
    def base_tables(self) -> tuple[RestTable, ...]:
        """Tables, one per actuator, without effects that cannot be tabulated."""
        return tuple(self._tables)

    def rest_rotation(self, pressures: Sequence[float] | Array) -> Array:
        """Rotation (n, 3) [rad] of the rest orientation of each joint under pressures (actuators,)
        [Pa].

        It is a rotation vector in the link's frame: the rest orientation of a joint under pressure
        is `segments.rest` followed by this rotation. Effects with memory, and effects that cannot
        be tabulated (`free_response.tabulates`), are left out.
        """
        rotation = self._tables[0].value(pressures[0])
        for table, pressure in zip(self._tables[1:], pressures[1:], strict=True):
            rotation = rotation + table.value(pressure)
        return rotation.reshape(self._shape)

    def rest_rotations(
        self, pressures: Array, modulus: float = 1.0, temperature: Array | float = ROOM_TEMPERATURE
    ) -> Array:
        """Rotations (rows, n, 3) [rad] as of `rest_rotation`, at pressures (actuators, rows) [Pa]
        and temperatures (rows,) [K], for a rubber with `modulus` [-] times the shear modulus, under
        effects without memory.
        """
        total = np.zeros((pressures.shape[1], self._shape[0] * 3))
        warm = np.broadcast_to(temperature, pressures.shape[1])[:, None, None]
        for stated, part, onto_joints, pressure in zip(
            self._stated, self._parts, self._angle_maps, pressures, strict=True
        ):
            if bends(self.model):
                stiffer = replace(part, shear_modulus=modulus * part.shear_modulus)
                response = SegmentResponse(stiffer, self.count, self.model)
                angles = response.angles(0.0, pressure[:, None, None], warm)
            else:
                scale = modulus * part.shear_modulus / stated.shear_modulus
                angles = angle_table(stated, self.count).values(pressure / scale)
            total += angles @ onto_joints.T
        return total.reshape(-1, *self._shape)

    def modulus_factors(self, temperature: Array) -> Array:
        """Factors (rows, n) [-] by which effects on the shear modulus change the stiffness of the
        joints, at temperatures (rows,) [K]; 1 for struts.
        """
        factors = np.ones((len(temperature), self._shape[0]))
        of_rubber = self._staged.modulus_factor(temperature)
        factors[:, self._struts :] = np.broadcast_to(of_rubber, len(temperature))[:, None]
        return factors

    def bend_factors(self, rest: Array, away: Array) -> Array | None:
        """Factors (rows, n, *k) [-] of the effects on the stiffness in bending, at distances `away`
        (*k) [rad] from rest bends (rows, n) [rad]; None if no effect changes it.
        """
        if not self._staged.stiffens:
            return None
        at_rest = np.expand_dims(rest, tuple(range(2, 2 + away.ndim)))
        factors = np.ones((*rest.shape, *away.shape))
        of_rubber = self._staged.stiffness_factor(at_rest + away, at_rest + 0.0 * away)
        factors[:, self._struts :] = np.broadcast_to(of_rubber, factors.shape)[:, self._struts :]
        return factors

    def volume(self, bend: Array) -> Array:
        """Air volume (actuators,) [m3] of chamber and supply tube.

        bend (n,) [rad] is the rotation of the joints about y from their rest. Two parallel arcs
        count as bent by the same angle; the volume that a twist exchanges between them is left out.
        """
        return self._rest_volume + self.volume_gain @ bend

    def step(
        self,
        dt: float,
        pressures: Sequence[float] | Array,
        actual: Array,
        temperature: float = ROOM_TEMPERATURE,
    ) -> Array:
        """Advance the memory of the effects by dt [s], and return the rest rotations (n, 3) [rad].

        pressures (actuators,) [Pa]. actual (n, 3) [rad]: actual rotation of the joints. temperature
        [K]. Effects on the springs are contained in the result, by `moved_rest`.
        """
        rest = self.free_rotation(dt, pressures, temperature)
        if not self._responses:
            return rest
        factor = np.ones(self._shape)
        coupling = np.zeros((self._shape[0], 2))
        joints = slice(self._struts, None)
        of_actuators = [
            response.springs(actual[joints, BEND_AXIS], rest[joints, BEND_AXIS], temperature)
            for response in self._responses
        ]
        factor[joints] = np.mean([factors for factors, _ in of_actuators], axis=0)
        stiffness = self.segments.stiffness[joints]
        coupled = np.mean([coupled for _, coupled in of_actuators])
        coupling[joints] = coupled * stiffness[:, [BEND_AXIS]] / stiffness[:, [0, 2]]
        return moved_rest(rest, actual, factor, coupling)

    def free_rotation(
        self, dt: float, pressures: Sequence[float] | Array, temperature: float = ROOM_TEMPERATURE
    ) -> Array:
        """Advance the memory of the effects by dt [s], and return the rotation (n, 3) [rad] of the
        joints without load.

        pressures (actuators,) [Pa], temperature [K]. Raises RuntimeError if the effects leave no
        equilibrium of the rubber.
        """
        if not self._responses:
            return self.rest_rotation(pressures)
        rotation = np.zeros(self._shape[0] * 3)
        for response, onto_joints, pressure in zip(
            self._responses, self._angle_maps, pressures, strict=True
        ):
            rotation += onto_joints @ response.angles(dt, float(pressure), temperature)
        return rotation.reshape(self._shape)

    def reset(self) -> None:
        """Reset the memory of the effects to that at rest at zero pressure."""
        for response in self._responses:
            response.reset()


def _altered(
    cut: SegmentChain, description: ChainDescription, segments: int, model: Model
) -> SegmentChain:
    """The segments with the stiffness of palm, mass of tip and bend at rest that effects state."""
    palm = palm_factor(model.effects) if description.turn else 1.0
    more = tip_mass(description.name, model.effects)
    stiffness, mass, center = cut.stiffness.copy(), cut.mass.copy(), cut.body_center.copy()
    stiffness[-segments:] *= palm
    mass[-1] += more
    center[-1] += more / mass[-1] * (cut.tip_offset - center[-1])
    bends = [rest_bend(name, model.effects) for name in description.actuators]
    half, rest = sum(bends) / (2.0 * segments), cut.rest.copy()
    if half != 0.0:  # of straight actuators, whose joints have no other rotation
        rest[-segments:] = [0.0, np.sin(half), 0.0, np.cos(half)]
    return replace(cut, rest=rest, stiffness=stiffness, mass=mass, body_center=center)
