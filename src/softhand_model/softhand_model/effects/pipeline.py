"""The effects of a model, stage by stage, with the memory of each."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace
from typing import TypeVar

import numpy as np

from softhand_common.numerics.arrays import Array
from softhand_model.effects.effect import STAGES, Effect
from softhand_model.effects.stages import (
    ElasticEffect,
    FlowEffect,
    InputEffect,
    LoadEffect,
    Memory,
    OutputEffect,
    Pulse,
    SectionShape,
    Strain,
    StructureEffect,
)

Kind = TypeVar("Kind", bound=Effect)
Ordered = TypeVar("Ordered", bound=Effect | type[Effect])

SECANTS = 30
SETTLED = 1e-13  # of the largest mass


def in_order(effects: Iterable[Ordered]) -> tuple[Ordered, ...]:
    """Effects, or their classes, in the order in which they act.

    They are sorted by stage; within a stage, factors come before added terms, and then lower ranks
    first.
    """
    return tuple(sorted(effects, key=_place))


def _place(effect: Effect | type[Effect]) -> tuple[int, bool, int]:
    return STAGES.index(effect.stage), getattr(effect, "adds", False), effect.rank


class StagedEffects:
    """Effects in the order in which they act, and their memory.

    Arrays are (lanes, rows, sections) as in `effects.stages`. memory: by effect name; `reset`
    empties it, so that the actuator is at rest at zero pressure.
    """

    def __init__(self, effects: Iterable[Effect] = ()) -> None:
        self.all = in_order(effects)
        self.input = _of(self.all, InputEffect)
        self.load = _of(self.all, LoadEffect)
        self.elastic = _of(self.all, ElasticEffect)
        self.structure = _of(self.all, StructureEffect)
        self.output = _of(self.all, OutputEffect)
        self.walls = [e for e in self.structure if overrides(e, StructureEffect, "wall_stress")]
        self.reset()

    def reset(self) -> None:
        """Empty the memory of all effects."""
        self.memory: dict[str, Memory] = {effect.name: {} for effect in self.all}

    @property
    def delays(self) -> bool:
        """Whether an effect delays the pressure."""
        return any(overrides(effect, InputEffect, "delay") for effect in self.input)

    def delay(self, elapsed: Array) -> Array:
        """Time [s] by which outputs come later than their pressures, at times `elapsed` [s] since
        the start of the run.
        """
        return np.asarray(sum((effect.delay(elapsed) for effect in self.input), 0.0 * elapsed))

    def chamber_pressure(self, read: Array, dt: Array | float) -> Array:
        """Pressure [Pa] in the chamber, given its reading [Pa]; advances memory by dt [s]."""
        for effect in self.input:
            read = effect.chamber_pressure(read, self.memory[effect.name], dt)
        return read

    def imposed_stretch(self, read: Array) -> Array:
        """Stretch [-] of the rubber of a strip, given its reading [-]."""
        for effect in self.input:
            read = effect.imposed_stretch(read)
        return read

    def modulus_factor(self, temperature: Array) -> Array | float:
        """Shear modulus divided by its nominal value at a temperature [K]."""
        factor: Array | float = 1.0
        for effect in self.load:
            factor = factor * effect.modulus_factor(temperature)
        return factor

    def act_on_load(self, load: Array, pressure: Array, shape: SectionShape) -> Array:
        """Load [-] with the effects, from that of the base model, at a chamber pressure [Pa]."""
        for effect in self.load:
            load = effect.act_on_load(load, pressure, shape)
        return load

    def stress(self, strain: Strain, shape: SectionShape, dt: Array | float) -> Array:
        """Elastic stress divided by the shear modulus [-], walls included; changes no memory."""
        stress = strain.elastic_term
        for effect in self.elastic:
            stress = effect.stress(stress, strain, shape, self.memory[effect.name], dt)
        for wall in self.walls:
            stress = wall.wall_stress(stress, strain, shape)
        return stress

    def remember(self, strain: Strain, shape: SectionShape, dt: Array | float) -> None:
        """Update the memory with the strain at the end of a step of dt [s]."""
        stress = strain.elastic_term
        for effect in self.elastic:
            memory, before = self.memory[effect.name], stress
            if effect is not self.elastic[-1]:
                stress = effect.stress(stress, strain, shape, memory, dt)
            effect.remember(before, strain, shape, memory, dt)

    def act_on_curvature(self, curvature: Array, pressure: Array, shape: SectionShape) -> Array:
        """Free curvature [1/m] with the effects, from that of the balance, at a chamber pressure
        [Pa].
        """
        for effect in self.structure:
            curvature = effect.act_on_curvature(curvature, pressure, shape)
        return curvature

    def stiffness_factor(self, bend: Array, rest: Array) -> Array | float:
        """Factor [-] of the effects on the stiffness, at actual bend and rest bend [rad]."""
        factor: Array | float = 1.0
        for effect in self.structure:
            if overrides(effect, StructureEffect, "stiffness_factor"):
                factor = factor * effect.stiffness_factor(bend, rest)
        return factor

    @property
    def stiffens(self) -> bool:
        """Whether any of the effects multiplies the stiffness, up or down."""
        return any(overrides(e, StructureEffect, "stiffness_factor") for e in self.structure)

    def bend_twist_coupling(self) -> Array | float:
        """Stiffness that couples lateral bending and twist / stiffness B in bending [-]."""
        coupling: Array | float = 0.0
        for effect in self.structure:
            coupling = coupling + effect.bend_twist_coupling()
        return coupling

    def tip_compliance(self) -> Array | float:
        """Displacement of a blocked tip per force [m/N]."""
        compliance: Array | float = 0.0
        for effect in self.structure:
            compliance = compliance + effect.tip_compliance()
        return compliance

    def grip_compliance(self) -> Array | float:
        """Stretch by which grips and load cell of a testing machine yield per stress [1/Pa]."""
        compliance: Array | float = 0.0
        for effect in self.structure:
            compliance = compliance + effect.grip_compliance()
        return compliance

    @property
    def bulges(self) -> bool:
        """Whether a blocked finger bulges between its base and the gauge."""
        return any(effect.bulges for effect in self.structure)

    def tip_force(self, force: Array, dt: Array | float) -> Array:
        """Force [N] of a blocked tip that reaches the force gauge; advances memory by dt [s]."""
        for effect in self.structure:
            force = effect.tip_force(force, self.memory[effect.name], dt)
        return force

    def reading(self, quantity: str, value: Array, dt: Array | float) -> Array:
        """Reading of a measured column, given its true value; advances memory by dt [s]."""
        for effect in self.output:
            if effect.shows(quantity):
                value = effect.reading(value, self.memory[effect.name], dt)
        return value


def moved_mass(pulse: Pulse, effects: Sequence[FlowEffect]) -> Array:
    """Masses (lanes or 1, pulses) [kg] that valve pulses move under flow effects, which act in
    their order.

    As an effect may change the pulse with the mass, mass and pulse are made to agree by one secant
    step for each pulse. The built-in effects are linear in the mass, so for them this is exact.
    """
    if not any(overrides(effect, FlowEffect, "act_on_pulse") for effect in effects):
        return _act_on_mass(pulse, effects)

    def answer(mass: Array) -> Array:
        real = pulse
        for effect in effects:
            real = effect.act_on_pulse(real, mass)
        return _act_on_mass(real, effects)

    mass = answer(np.zeros_like(pulse.naive))
    excess_before, step = -mass, mass
    for _ in range(SECANTS):
        excess = mass - answer(mass)
        open_yet = np.abs(excess) > SETTLED * np.max(np.abs(mass))
        if not open_yet.any():
            break
        change = excess - excess_before
        secant = open_yet & (change != 0.0)
        slope = np.where(secant, change, 1.0) / np.where(secant, step, 1.0)
        step = np.where(open_yet, -excess / slope, 0.0)
        mass, excess_before = mass + step, excess
    return mass


def _act_on_mass(pulse: Pulse, effects: Sequence[FlowEffect]) -> Array:
    mass = pulse.naive
    for effect in effects:
        mass = effect.act_on_mass(mass, pulse)
    return mass


def at_modulus(shape: SectionShape, factor: Array | float) -> SectionShape:
    """The sections with their shear modulus times a factor [-]."""
    return replace(shape, shear_modulus=shape.shear_modulus * np.asarray(factor))


def remembers(effects: Sequence[Effect]) -> bool:
    """Whether any of the effects has memory."""
    return any(effect.has_memory for effect in effects)


def _of(effects: Iterable[Effect], kind: type[Kind]) -> tuple[Kind, ...]:
    return tuple(effect for effect in effects if isinstance(effect, kind))


def overrides(effect: Effect, base: type[Effect], *methods: str) -> bool:
    """Whether the class of an effect has its own version of one of these methods of `base`."""
    return any(getattr(type(effect), name) is not getattr(base, name) for name in methods)
