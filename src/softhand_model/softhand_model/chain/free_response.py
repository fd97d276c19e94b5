"""Free bending of an actuator's segments over pressure: from tables for the base model and under
effects that only change the law of the rubber, and stage by stage under other effects.
"""

from __future__ import annotations

from functools import lru_cache
from typing import Any

import numpy as np

from softhand_common.numerics.arrays import Array
from softhand_model.bending.balance import SteppedBalance, free_curvature
from softhand_model.chain.segments import BEND_AXIS
from softhand_model.effects.catalogue import effect_classes
from softhand_model.effects.effect import Effect
from softhand_model.effects.pipeline import StagedEffects, at_modulus, overrides
from softhand_model.effects.stages import (
    ElasticEffect,
    InputEffect,
    LoadEffect,
    SectionShape,
    StructureEffect,
)
from softhand_model.gas import ROOM_TEMPERATURE
from softhand_model.hand.actuator import Actuator
from softhand_model.model_file import Model

REST_INTERVALS = 1024
HIGHEST_OVER_LIMIT = 3.0  # the table ends at three times the actuator's pressure limit
BENDING_FREELY = ("wall_stress", "act_on_curvature")
STIFFNESS_HOOKS = ("stiffness_factor", "bend_twist_coupling")
KEPT_TABLES = 64
WITHOUT_EFFECTS = Model()
NEARBY = 10.0  # [Pa] on either side, for the slope under effects by a difference


class NoEquilibriumError(RuntimeError):
    """There is no equilibrium: no stretch balances the load of a section, or no posture balances
    the weight of a hand.
    """


class RestTable:
    """Rotations of the joints of a chain that the pressure of one actuator causes, by cubic Hermite
    interpolation.

    The table holds the exact integral of the free curvature over each segment, already mapped onto
    the chain's joint axes by `onto_joints` (m, n): values (m,) [rad] = onto_joints @ segment angles
    (n,). Between its points the error is below 1e-8 of the value. Suction counts as zero pressure;
    beyond the table, values go on in a straight line, as kappa(p) nearly does.

    step [Pa]: width of an interval; cubic (REST_INTERVALS + 1, 4, m): coefficients of 1, t, t**2
    and t**3 with t the pressure in an interval over its width. model: with effects that `tabulates`
    accepts.
    """

    def __init__(
        self, actuator: Actuator, segments: int, onto_joints: Array, model: Model = WITHOUT_EFFECTS
    ) -> None:
        self.step = float(_table_pressures(actuator)[-1]) / REST_INTERVALS
        acting = ((e.name, *map(float, e.values.values())) for e in model.effects if _acts(e))
        found = _tabulated(actuator, segments, tuple(acting))
        value, slope = (part @ onto_joints.T for part in found)
        self.cubic = hermite(value, slope * self.step)

    def __deepcopy__(self, memo: dict[int, object]) -> RestTable:
        """The same object: tables are constant, and snapshots of a simulation copy the models."""
        return self

    def value(self, pressure: float) -> Array:
        """Values (m,) [rad] at a gauge pressure [Pa]."""
        index, t = self._place(pressure)
        return np.array((1.0, t, t * t, t * t * t)) @ self.cubic[index]

    def values(self, pressures: Array) -> Array:
        """Values (k, m) [rad] at gauge pressures (k,) [Pa]."""
        relative = np.maximum(pressures, 0.0) / self.step
        index = np.minimum(relative.astype(int), REST_INTERVALS)
        t = (relative - index)[:, None]
        c = self.cubic[index]
        return np.asarray(c[:, 0] + t * (c[:, 1] + t * (c[:, 2] + t * c[:, 3])))

    def slope(self, pressure: float) -> Array:
        """Derivative (m,) [rad/Pa] of the values by the pressure; under suction, the one at zero
        pressure.
        """
        index, t = self._place(pressure)
        return np.array((0.0, 1.0, 2.0 * t, 3.0 * t * t)) @ self.cubic[index] / self.step

    def _place(self, pressure: float) -> tuple[int, float]:
        relative = max(float(pressure), 0.0) / self.step
        index = min(int(relative), REST_INTERVALS)
        return index, relative - index


def _table_pressures(actuator: Actuator) -> Array:
    """Gauge pressures (REST_INTERVALS + 1,) [Pa] between which a table interpolates."""
    return np.linspace(0.0, HIGHEST_OVER_LIMIT * actuator.max_pressure, REST_INTERVALS + 1)


@lru_cache(maxsize=KEPT_TABLES)
def _tabulated(
    actuator: Actuator, segments: int, acting: tuple[tuple[Any, ...], ...]
) -> tuple[Array, Array]:
    """`segment_angles` at the pressures of a table, under effects given by name and values; kept,
    as each simulation of a hand needs them again, so they cannot be written.
    """
    pressures = _table_pressures(actuator)
    if acting:
        model = Model(effects=tuple(_effect(*one) for one in acting))
        found = SegmentResponse(actuator, segments, model).angles_and_slopes(pressures)
    else:
        found = segment_angles(actuator, segments, pressures)
    for one in found:
        one.setflags(write=False)
    return found


def _effect(name: str, *values: float) -> Effect:
    kind = effect_classes()[name]
    return kind(**dict(zip((one.name for one in kind.parameters), values, strict=True)))


@lru_cache(maxsize=KEPT_TABLES)
def angle_table(actuator: Actuator, segments: int) -> RestTable:
    """Table of the angles (segments,) [rad] of the segments of an actuator under the base model;
    tables are cached.

    They depend on pressure over modulus alone: one table serves rubber of any stiffness.
    """
    return RestTable(actuator, segments, np.eye(segments))


def hermite(value: Array, slope: Array) -> Array:
    """Cubic polynomials through k points that are 1 apart, with given values and slopes (k, ..., m)
    at the points.

    Returns the coefficients (k, ..., 4, m) of 1, t, t**2 and t**3. Row i is for the interval after
    point i, with t from 0 to 1; the last row is the straight line that goes on from the last point.
    """
    rise, first, last = np.diff(value, axis=0), slope[:-1], slope[1:]
    inside = np.stack(
        [value[:-1], first, 3.0 * rise - 2.0 * first - last, first + last - 2.0 * rise], axis=-2
    )
    zero = np.zeros_like(value[-1])
    after = np.stack([value[-1], slope[-1], zero, zero], axis=-2)
    return np.concatenate([inside, after[None]])


def segment_angles(actuator: Actuator, segments: int, pressures: Array) -> tuple[Array, Array]:
    """Exact angles (m, n) [rad] of n segments at pressures (m,) [Pa] without load, and their
    derivatives [rad/Pa].

    The derivative is eq. 3.31 with the side walls of 3.35: dkappa/dp = ratio/(4*G*d*(1 +
    3*lambda**-4)).
    """
    x, weight = actuator.segment_quadrature(segments)
    curvature = actuator.free_curvature(pressures[:, None, None], x)
    stretch = 1.0 + curvature * actuator.height(x)
    slope = actuator.side_wall_ratio(x) / (
        4.0 * actuator.shear_modulus * actuator.wall(x) * (1.0 + 3.0 * stretch**-4.0)
    )
    return np.sum(weight * curvature, axis=-1), np.sum(weight * slope, axis=-1)


class SegmentResponse:
    """Angles of the segments of an actuator without load, step by step under effects with memory.

    Pressures and temperatures are numbers, or (lanes, 1, 1) for many at once; angles are then
    (lanes, n).
    """

    def __init__(self, actuator: Actuator, segments: int, model: Model) -> None:
        x, self._weight = actuator.segment_quadrature(segments)
        self._shape = SectionShape(
            *actuator.sides(x), actuator.side_wall_ratio(x), actuator.shear_modulus
        )
        self._stepped = SteppedBalance(StagedEffects(model.effects))

    def reset(self) -> None:
        """Reset the memory of the effects to that at rest at zero pressure."""
        self._stepped.reset()

    def angles(self, dt: float, pressure: Array | float, temperature: Array | float) -> Array:
        """Free angle (n,) [rad] of each segment after a step dt [s] at a gauge pressure [Pa] and
        temperature [K].

        Raises NoEquilibriumError if parameters of the effects let the elastic stress fall with the
        stretch, so that nothing balances the load.
        """
        staged = self._stepped.staged
        chamber = staged.chamber_pressure(np.asarray(pressure, float), dt)
        shape = at_modulus(self._shape, staged.modulus_factor(np.asarray(temperature, float)))
        curvature = free_curvature(self._stepped, chamber, shape, dt)
        if not self._stepped.settled:
            raise NoEquilibriumError(
                f"under the effects {', '.join(staged.memory)} the rubber has no equilibrium at "
                f"{float(np.max(chamber)):.4g} Pa"
            )
        return np.sum(self._weight * curvature, axis=-1)

    def angles_and_slopes(self, pressures: Array) -> tuple[Array, Array]:
        """As `segment_angles` at gauge pressures (m,) [Pa], under effects without memory."""
        below, there, above = (
            self.angles(0.0, (pressures + shift)[:, None, None], ROOM_TEMPERATURE)
            for shift in (-NEARBY, 0.0, NEARBY)
        )
        return there, (above - below) / (2.0 * NEARBY)

    def springs(
        self, bend: Array, rest: Array, temperature: Array | float
    ) -> tuple[Array, Array | float]:
        """Effects on the springs of the joints: (factors (n, 3) [-] on the stiffness about x, y and
        z, stiffness that couples lateral bending and twist over that in bending [-]).

        bend, rest (n,) [rad]: actual and free bend of the joints. temperature [K].
        """
        staged = self._stepped.staged
        factor = np.full((*np.shape(bend), 3), staged.modulus_factor(np.asarray(temperature)))
        factor[..., BEND_AXIS] *= staged.stiffness_factor(bend, rest)
        return factor, staged.bend_twist_coupling()


def bends(model: Model) -> bool:
    """Whether any effect of the model changes the bending of chains; weight and sensors do not."""
    return any(_acts(effect) for effect in model.effects)


def tabulates(model: Model) -> bool:
    """Whether the actuator's free shape can be tabulated over the pressure. True if the shape is a
    smooth function of the pressure under the model's effects, and no effect changes the springs of
    the base model. False for a user's own effects, whose form is not known.
    """
    return all(_is_smooth(effect) for effect in model.effects if _acts(effect))


def _acts(effect: Effect) -> bool:
    if isinstance(effect, LoadEffect):
        return overrides(effect, LoadEffect, "act_on_load", "modulus_factor")
    if isinstance(effect, StructureEffect):
        return overrides(effect, StructureEffect, *BENDING_FREELY, *STIFFNESS_HOOKS)
    return isinstance(effect, InputEffect | ElasticEffect)


def _is_smooth(effect: Effect) -> bool:
    if effect.has_memory or type(effect) is not effect_classes().get(effect.name):
        return False
    if isinstance(effect, StructureEffect):
        return not overrides(effect, StructureEffect, *STIFFNESS_HOOKS)
    return isinstance(effect, ElasticEffect)
