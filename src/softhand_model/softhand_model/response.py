"""Free bending of one actuator's segments under a model's effects, stage by stage; the base model
needs none of it.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from softhand_model.actuator import Actuator
from softhand_model.effects.effect import Effect
from softhand_model.effects.staged import StagedEffects, at_modulus, overrides
from softhand_model.effects.stages import (
    ElasticEffect,
    InputEffect,
    LoadEffect,
    SectionShape,
    StructureEffect,
)
from softhand_model.free_bending import SteppedBalance, free_curvature
from softhand_model.model_file import Model

Array = NDArray[np.float64]

BEND = 1  # index of the bending axis (y)
ACTING_ON_CHAINS = (
    "wall_stress",
    "act_on_curvature",
    "stiffness_factor",
    "bend_twist_coupling",
)


class SegmentResponse:
    """Free angles of an actuator's segments, with the effects' memory from step to step.

    Pressures and temperatures are numbers, or (lanes, 1, 1) for many at once; angles are then
    (lanes, n).
    """

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
        self._stepped = SteppedBalance(StagedEffects(model.effects))

    def reset(self) -> None:
        """Forget everything: at rest at zero pressure."""
        self._stepped.reset()

    def angles(self, dt: float, pressure: Array | float, temperature: Array | float) -> Array:
        """Free angle (n,) [rad] of each segment after a step dt [s] at a gauge pressure [Pa] and
        temperature [K].

        Raises RuntimeError where the effects' parameters let the elastic side fall, so that nothing
        balances the load.
        """
        staged = self._stepped.staged
        chamber = staged.chamber_pressure(np.asarray(pressure, float), dt)
        shape = at_modulus(self._shape, staged.modulus_factor(np.asarray(temperature, float)))
        curvature = free_curvature(self._stepped, chamber, shape, dt)
        if not self._stepped.settled:
            raise RuntimeError(
                f"the effects {', '.join(staged.memory)} leave no equilibrium of the rubber at "
                f"{float(np.max(chamber)):.4g} Pa"
            )
        return np.sum(self._weight * curvature, axis=-1)

    def springs(
        self, bend: Array, rest: Array, temperature: Array | float
    ) -> tuple[Array, Array | float]:
        """What effects do to the joints' springs: factors (n, 3) [-] on the stiffness about x, y
        and z, and the coupling [-] of lateral bending and twist.

        bend, rest (n,) [rad]: actual and free bend of the joints; temperature in [K].
        """
        staged = self._stepped.staged
        factor = np.full((*np.shape(bend), 3), staged.modulus_factor(np.asarray(temperature)))
        factor[..., BEND] *= staged.stiffness_factor(bend, rest)
        return factor, staged.bend_twist_coupling()


def bends(model: Model) -> bool:
    """Whether any effect of the model changes how chains bend; weight, gauges and sensors do
    not.
    """
    return any(_acts(effect) for effect in model.effects)


def _acts(effect: Effect) -> bool:
    if isinstance(effect, LoadEffect):
        return overrides(effect, LoadEffect, "act_on_load", "modulus_factor")
    if isinstance(effect, StructureEffect):
        return overrides(effect, StructureEffect, *ACTING_ON_CHAINS)
    return isinstance(effect, InputEffect | ElasticEffect)
