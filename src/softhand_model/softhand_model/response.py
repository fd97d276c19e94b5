"""Free bending of one actuator's segments under a model's effects, stage by stage; the base model
needs none of it.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from softhand_model import section
from softhand_model.actuator import Actuator
from softhand_model.effects.effect import Effect
from softhand_model.effects.stages import (
    ElasticEffect,
    InputEffect,
    LoadEffect,
    Memory,
    SectionShape,
    StructureEffect,
)
from softhand_model.model_file import Model

Array = NDArray[np.float64]

NEWTON_STEPS = 40
TOLERANCE = 1e-10
DIFFERENCE = 1e-6  # for the slope of the elastic side
HIGHEST_STRETCH = 12.0


class SegmentResponse:
    """Free angles of an actuator's segments, with the effects' memory from step to step."""

    def __init__(self, actuator: Actuator, segments: int, model: Model) -> None:
        x, self._weight = actuator.segment_quadrature(segments)
        self._shape = SectionShape(
            actuator.height(x),
            actuator.width(x),
            actuator.wall,
            actuator.side_wall,
            actuator.side_wall_ratio(x),
            actuator.shear_modulus,
        )
        self._input = [effect for effect in model.effects if isinstance(effect, InputEffect)]
        self._load = [effect for effect in model.effects if isinstance(effect, LoadEffect)]
        elastic = [effect for effect in model.effects if isinstance(effect, ElasticEffect)]
        self._elastic = sorted(elastic, key=lambda effect: effect.adds)
        self._structure = [
            effect for effect in model.effects if isinstance(effect, StructureEffect)
        ]
        self.reset()

    def reset(self) -> None:
        """Forget everything: at rest at zero pressure."""
        self._memory: dict[str, Memory] = {
            effect.name: {}
            for effect in [*self._input, *self._load, *self._elastic, *self._structure]
        }
        self._stretch = np.ones_like(self._weight)

    def angles(self, dt: float, pressure: float, temperature: float) -> Array:
        """Free angle (n,) [rad] of each segment after a step dt [s] at a gauge pressure [Pa] and
        temperature [K].
        """
        for effect in self._input:
            pressure = effect.chamber_pressure(pressure, self._memory[effect.name], dt)
        pressure = max(pressure, 0.0)
        self._stretch = self._balance(self._loads(pressure, temperature), dt)
        self._remember(dt)
        curvature = (self._stretch - 1.0) / self._shape.height
        for structural in self._structure:
            curvature = structural.act_on_curvature(curvature, pressure, self._shape)
        return np.sum(self._weight * curvature, axis=-1)

    def stiffness_factor(self, bend: Array, rest: Array, temperature: float) -> Array:
        """Factor (n,) [-] on the joints' stiffness at actual and free bend (n,) [rad]."""
        factor = np.full_like(bend, self._modulus_factor(temperature))
        for effect in self._structure:
            factor = factor * effect.stiffness_factor(bend, rest)
        return factor

    def _modulus_factor(self, temperature: float) -> float:
        return float(np.prod([effect.modulus_factor(temperature) for effect in self._load]))

    def _loads(self, pressure: float, temperature: float) -> Array:
        shape = self._shape
        load = section.bending_load(
            pressure,
            shape.height,
            shape.wall,
            shape.ratio,
            shape.shear_modulus * self._modulus_factor(temperature),
        )
        for effect in self._load:
            load = effect.act_on_load(load, pressure, shape)
        return load

    def _stress(self, stretch: Array, dt: float) -> Array:
        stress = section.elastic_term(stretch)
        for effect in self._elastic:
            stress = effect.stress(stress, stretch, self._shape, self._memory[effect.name], dt)
        return stress

    def _balance(self, load: Array, dt: float) -> Array:
        """Stretch at which the elastic side carries the load, by Newton from the last one.

        Raises RuntimeError if it does not converge: the effects' parameters let the elastic side
        fall.
        """
        stretch = self._stretch.copy()
        for _ in range(NEWTON_STEPS):
            stress = self._stress(stretch, dt)
            if np.all(np.abs(stress - load) <= TOLERANCE * (1.0 + load)):
                return stretch
            slope = (self._stress(stretch + DIFFERENCE, dt) - stress) / DIFFERENCE
            step = (stress - load) / slope
            # half the way to 0.2 at most, so that the next point stays where lambda**-3 is tame
            step = np.clip(step, stretch - HIGHEST_STRETCH, (stretch - 0.2) / 2.0)
            stretch = stretch - step
        raise RuntimeError(
            f"the effects {', '.join(self._memory)} leave no equilibrium of the rubber at a load "
            f"of {float(np.max(load)):.3g}"
        )

    def _remember(self, dt: float) -> None:
        stress = section.elastic_term(self._stretch)
        for effect in self._elastic:
            memory = self._memory[effect.name]
            after = effect.stress(stress, self._stretch, self._shape, memory, dt)
            effect.remember(stress, self._stretch, self._shape, memory, dt)
            stress = after


def bends(model: Model) -> bool:
    """Whether any effect of the model changes how chains bend; weight and sensors do not."""
    return any(_acts(effect) for effect in model.effects)


def _acts(effect: Effect) -> bool:
    return effect.name != "gravity" and isinstance(
        effect, InputEffect | LoadEffect | ElasticEffect | StructureEffect
    )
