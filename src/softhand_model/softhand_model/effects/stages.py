"""One base class per stage of the model: the methods by which its effects act.

Pressures are gauge. Every argument is a number or an array that broadcasts to (lanes, rows,
sections): a lane is one set of parameter values, a row is a run, sample or segment, and sections
lie along the actuator; what has no sections has a last axis of 1 (or is a number). `memory` is a
dictionary of the effect's own, empty at the start and after a reset, one for each actuator; a
method may be called several times within a time step, so it changes memory in `remember` alone
(the methods of stages that are called once say so). dt [s] is a number or (rows, 1), and 0 at a
run's first sample.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, ClassVar

import numpy as np

from softhand_common.numerics.arrays import Array, Flags, Indices
from softhand_model.effects.effect import Effect

Memory = dict[str, Any]


@dataclass(frozen=True)
class SectionShape:
    """Sections at which the model is evaluated: height, width, wall, side_wall [m], ratio [-] (eq.
    3.35) and shear_modulus [Pa], as arrays that broadcast against each other.
    """

    height: Array
    width: Array
    wall: Array | float
    side_wall: Array | float
    ratio: Array
    shear_modulus: Array | float

    def of_rows(self, rows: Indices) -> SectionShape:
        """The sections of these rows of arrays (lanes, rows, sections); rows may repeat."""
        parts = {
            name: value if np.ndim(value) < 2 or value.shape[-2] == 1 else value[..., rows, :]
            for name, value in vars(self).items()
        }
        return SectionShape(**parts)


@dataclass(frozen=True)
class Strain:
    """How the rubber is strained: stretch lambda [-], and quantities that follow from it in a mode
    of deformation.

    mode: `pure_shear` (bending), `uniaxial`, `equibiaxial` or `linear` (the base `linear`, where
    lambda - 1 is the output over the largest one of the set). With an energy W(J1, J2) per volume
    the nominal stress along the stretch is 2*(dW/dJ1 + second*dW/dJ2)*q, `second` as below.
    """

    stretch: Array
    mode: str = "pure_shear"

    @cached_property
    def _inverse(self) -> Array:
        return 1.0 / self.stretch

    @cached_property
    def elastic_term(self) -> Array:
        """Stress q [-] without effects, divided by the shear modulus: lambda - lambda**-3 (eq.
        3.21), uniaxial lambda - lambda**-2, equibiaxial lambda - lambda**-5, linear lambda - 1.

        >>> Strain(2.0, "uniaxial").elastic_term
        1.75
        """
        if self.mode == "linear":
            return self.stretch - 1.0
        powers = self._inverse * self._inverse
        if self.mode == "pure_shear":
            powers = powers * self._inverse
        elif self.mode == "equibiaxial":
            powers = powers * powers * self._inverse
        return self.stretch - powers

    @cached_property
    def invariant(self) -> Array:
        """Invariant J1 [-]: lambda**2 + lambda**-2 - 2 (eq. 3.18), uniaxial lambda**2 + 2/lambda -
        3, equibiaxial 2*lambda**2 + lambda**-4 - 3, linear (lambda - 1)**2; written so that
        rounding does not blur it near lambda = 1.

        >>> Strain(3.0).invariant, Strain(2.0, "uniaxial").invariant
        (7.111111111111111, 2.0)
        """
        if self.mode == "pure_shear":
            return (self.stretch - self._inverse) ** 2
        if self.mode == "equibiaxial":  # that of uniaxial compression to lambda**-2
            shorter = self._inverse * self._inverse
            return (shorter - 1.0) ** 2 * (1.0 + 2.0 * self.stretch * self.stretch)
        square = (self.stretch - 1.0) ** 2
        return square if self.mode == "linear" else square * (1.0 + 2.0 * self._inverse)

    @cached_property
    def second_invariant(self) -> Array:
        """Invariant J2 [-]: that of the inverse stretches; in pure shear J1 (eq. 3.18).

        >>> Strain(2.0, "equibiaxial").second_invariant
        13.5
        """
        if self.mode == "uniaxial":
            return Strain(self.stretch**0.5, "equibiaxial").invariant
        if self.mode == "equibiaxial":
            return Strain(self.stretch * self.stretch, "uniaxial").invariant
        return self.invariant

    @cached_property
    def second(self) -> Array | float:
        """Weight [-] of dW/dJ2 in the stress, relative to that of dW/dJ1: 1/lambda in uniaxial
        tension, 1 in pure shear (and for the base `linear`), lambda**2 in equibiaxial tension.
        """
        if self.mode == "uniaxial":
            return self._inverse
        return self.stretch * self.stretch if self.mode == "equibiaxial" else 1.0


class InputEffect(Effect):
    """Effects on the driving input: the pressure in the chamber, or the stretch of a strip."""

    stage: ClassVar[str] = "input"

    def chamber_pressure(self, pressure: Array, memory: Memory, dt: Array | float) -> Array:
        """Pressure [Pa] in the chamber, from its reading [Pa]; called once per step, may change
        memory.
        """
        return pressure

    def delay(self, elapsed: Array) -> Array | float:
        """Time [s] by which the output comes later than its pressure, at times `elapsed` [s] since
        the start of the run; negative if it comes earlier.
        """
        return 0.0

    def imposed_stretch(self, stretch: Array) -> Array:
        """Stretch [-] of the rubber of a strip, from its reading [-]."""
        return stretch


class LoadEffect(Effect):
    """Effects on the load s = p*ratio*h/(4*G*d), or on the modulus G in it."""

    stage: ClassVar[str] = "load"

    def act_on_load(self, load: Array, pressure: Array, shape: SectionShape) -> Array:
        """Load [-] of the sections with this effect, from that without it, at a chamber pressure
        [Pa].
        """
        return load

    def modulus_factor(self, temperature: Array) -> Array | float:
        """Shear modulus at a temperature [K] divided by the nominal one. It divides the load and
        multiplies the stiffness of joints.
        """
        return 1.0


class ElasticEffect(Effect):
    """Effects on the elastic stress, which balances the load. In the base model it is q(lambda).
    Factors act before added terms.

    adds: whether it adds to the stress, so that it acts after all factors. largest: entries of its
    memory that belong to the specimen and not to the run, such as the largest stretch so far, with
    their values for a virgin specimen.
    """

    stage: ClassVar[str] = "elastic"
    adds: ClassVar[bool] = False
    largest: ClassVar[Mapping[str, float]] = {}

    def allows(self, shape: SectionShape) -> Flags | bool:
        """Whether the parameters make sense for sections of this shape; bounds are checked
        elsewhere.
        """
        return True

    def stress(
        self, stress: Array, strain: Strain, shape: SectionShape, memory: Memory, dt: Array | float
    ) -> Array:
        """Elastic stress divided by the shear modulus [-] with this effect, from that without it;
        changes no memory.
        """
        return stress

    def remember(
        self, stress: Array, strain: Strain, shape: SectionShape, memory: Memory, dt: Array | float
    ) -> None:
        """Update the memory with the strain at the end of a step, and the stress without this
        effect.
        """


class StructureEffect(Effect):
    """Effects of the structure: walls, joints, tip.

    bulges: whether a blocked finger bulges, see `bending.loaded_finger.bulging`.
    """

    stage: ClassVar[str] = "structure"
    bulges: ClassVar[bool] = False
    bases: ClassVar[frozenset[str]] = frozenset({"pneuflex"})

    def wall_stress(self, stress: Array, strain: Strain, shape: SectionShape) -> Array:
        """Elastic stress of all walls divided by the shear modulus [-], from that of the top wall
        with its effects.
        """
        return stress

    def act_on_curvature(self, curvature: Array, pressure: Array, shape: SectionShape) -> Array:
        """Free curvature [1/m] with this effect, from that of the balance, at a chamber pressure
        [Pa].
        """
        return curvature

    def stiffness_factor(self, bend: Array, rest: Array) -> Array:
        """Factor [-] on the stiffness, at actual bend and rest bend [rad] (or curvatures [1/m])."""
        return np.ones_like(bend)

    def bend_twist_coupling(self) -> Array | float:
        """Stiffness that couples lateral bending and twist / bending stiffness [-]."""
        return 0.0

    def tip_compliance(self) -> Array | float:
        """Displacement of a blocked tip per force [m/N]."""
        return 0.0

    def grip_compliance(self) -> Array | float:
        """Stretch by which grips and load cell of a testing machine yield per stress [1/Pa]."""
        return 0.0

    def tip_force(self, force: Array, memory: Memory, dt: Array | float) -> Array:
        """Force [N] of a blocked tip that reaches the force gauge; called once per sample, may
        change memory.
        """
        return force


class OutputEffect(Effect):
    """What a sensor reads of a true value.

    quantity: the measured column of that sensor, or several columns of which a set has one.
    """

    stage: ClassVar[str] = "output"
    quantity: ClassVar[str | tuple[str, ...]] = ""

    def shows(self, column: str) -> bool:
        """Whether the effect acts on the sensor of this measured column."""
        return column in ((self.quantity,) if isinstance(self.quantity, str) else self.quantity)

    def reading(self, value: Array, memory: Memory, dt: Array | float) -> Array:
        """Reading of a true value, in its unit; called once per sample, may change memory."""
        return value


@dataclass(frozen=True)
class Pulse:
    """Valve pulses: arrays (lanes or 1, pulses).

    inflating [bool]; duration [s]; p_in and p_out [Pa], absolute, when the valve is switched on;
    friction_integral and injector_integral [Pa s]; naive [kg], the naive term c*p_in*duration of
    the base model, with the duration and p_in of this pulse.
    """

    inflating: Flags
    duration: Array
    p_in: Array
    p_out: Array
    friction_integral: Array
    injector_integral: Array
    naive: Array

    def lasting(self, duration: Array) -> Pulse:
        """The pulse with another duration [s]; its integrals and naive term change in
        proportion.
        """
        share = duration / np.where(self.duration > 0.0, self.duration, np.inf)
        return replace(
            self,
            duration=duration,
            friction_integral=self.friction_integral * share,
            injector_integral=self.injector_integral * share,
            naive=self.naive * share,
        )

    def fed_at(self, p_in: Array) -> Pulse:
        """The pulse with another p_in [Pa]; its naive term changes in proportion, its measured
        integrals do not.
        """
        return replace(self, p_in=p_in, naive=self.naive * (p_in / self.p_in))


class FlowEffect(Effect):
    """Effects on the air mass that a valve pulse moves; most parameters have one value per
    direction.

    Parameter values in lanes are (lanes, 1, 1), as in all effects; `self.of(name)` returns them as
    (lanes, 1).

    replaces_naive: whether the naive term is left out, so that its calibration has no effect.
    """

    stage: ClassVar[str] = "flow"
    experiments: ClassVar[frozenset[str]] = frozenset({"valve_pulse"})
    replaces_naive: ClassVar[bool] = False

    def of(self, parameter: str) -> Array:
        """Value of a parameter in a shape that broadcasts against pulses."""
        return np.asarray(self.values[parameter], float).reshape(-1, 1)

    def by_direction(self, parameter: str, pulse: Pulse) -> Array:
        """Values of `<parameter>_inflate` and `<parameter>_deflate`, each for the pulses of its
        direction.
        """
        inflate, deflate = self.of(f"{parameter}_inflate"), self.of(f"{parameter}_deflate")
        return np.where(pulse.inflating, inflate, deflate)

    def act_on_pulse(self, pulse: Pulse, mass: Array) -> Pulse:
        """The true pulse. mass [kg]: moved air, as computed so far in the iteration."""
        return pulse

    def act_on_mass(self, mass: Array, pulse: Pulse) -> Array:
        """Mass [kg] that the pulses move with this effect, from that without it."""
        return mass

    def leak(self, pressure_abs: Array) -> Array | float:
        """Air [kg/s] that leaves a channel at an absolute pressure [Pa] between two pulses. Only
        the simulator uses it, as the lab has data on pulses only.
        """
        return 0.0


def decay(dt: Array | float, time_constant: Any) -> tuple[Array, Array]:
    """(exp(-x), (1 - exp(-x))/x) [-] with x = dt/time_constant: the remaining shares of an initial
    value after dt [s], and of a ramp over dt at its end.

    >>> left, share = decay(0.0, 1.0)
    >>> float(left), float(share)
    (1.0, 1.0)
    """
    steps = np.asarray(dt, float) / time_constant
    gone = -np.expm1(-steps)
    return 1.0 - gone, np.where(steps > 0.0, gone, 1.0) / np.where(steps > 0.0, steps, 1.0)


def lagged(value: Array, memory: Memory, dt: Array | float, time_constant: Any) -> Array:
    """The value that follows `value` with a time constant [s], after a step of dt [s]; 0 before the
    first step.

    memory: stores the following value, and `value`.
    """
    follows, before = memory.get("state", (0.0, 0.0))
    left, share = decay(dt, time_constant)
    follows = value - share * (value - before) + left * (follows - before)
    memory["state"] = follows, value
    return follows
