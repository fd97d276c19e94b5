"""One base class per stage: the method by which its effects act, and the order in which the stages
run.

Pressures are gauge. `memory` is a dictionary of the effect's own, empty at the start and after a
reset, one for each actuator; a method may be called several times within a time step, so it changes
memory in `remember` alone (the methods of stages that are called once say so).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from softhand_model.effects.effect import Effect

Array = NDArray[np.float64]
Memory = dict[str, Any]


@dataclass(frozen=True)
class SectionShape:
    """Sections at which the model is evaluated: height, width, wall, side_wall, ratio (eq. 3.35),
    all of one shape.
    """

    height: Array
    width: Array
    wall: float
    side_wall: float
    ratio: Array
    shear_modulus: float


class InputEffect(Effect):
    """What pressure acts in the chamber."""

    stage: ClassVar[str] = "input"

    def chamber_pressure(self, pressure: float, memory: Memory, dt: float) -> float:
        """Pressure [Pa] in the chamber, given the one that is read [Pa]; called once a step, may
        change memory.
        """
        return pressure


class LoadEffect(Effect):
    """What changes the load s = p*ratio*h/(4*G*d), or the modulus in it."""

    stage: ClassVar[str] = "load"

    def act_on_load(self, load: Array, pressure: float, shape: SectionShape) -> Array:
        """Load [-] at the sections for a chamber pressure [Pa]."""
        return load

    def modulus_factor(self, temperature: float) -> float:
        """Shear modulus over its nominal value at a temperature [K]; it divides the load and
        stiffens the joints.
        """
        return 1.0


class ElasticEffect(Effect):
    """What balances the load: the base is q(lambda); factors run before added terms."""

    stage: ClassVar[str] = "elastic"
    adds: ClassVar[bool] = False

    def stress(
        self, stress: Array, stretch: Array, shape: SectionShape, memory: Memory, dt: float
    ) -> Array:
        """Elastic side [-] of the balance with this effect, given that without it, at a stretch;
        changes no memory.
        """
        return stress

    def remember(
        self, stress: Array, stretch: Array, shape: SectionShape, memory: Memory, dt: float
    ) -> None:
        """Take over the solved stretch of a step, with the stress that came before this effect in
        it.
        """


class StructureEffect(Effect):
    """What changes curvature or joints once the balance is solved."""

    stage: ClassVar[str] = "structure"

    def act_on_curvature(self, curvature: Array, pressure: float, shape: SectionShape) -> Array:
        """Free curvature [1/m] at the sections."""
        return curvature

    def stiffness_factor(self, bend: Array, rest: Array) -> Array:
        """Factor (n,) [-] on the joints' stiffness, given actual and free bend (n,) [rad]."""
        return np.ones_like(bend)


class OutputEffect(Effect):
    """What a sensor shows of the true value."""

    stage: ClassVar[str] = "output"

    def reading(self, value: float, memory: Memory, dt: float) -> float:
        """Reading of a true value, in its unit; called once a sample, may change memory."""
        return value
