"""What differs from episode to episode: the object's place, mass and friction, and the parameters
of the model, as uncertain as the lab found them.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from scipy.special import ndtr, ndtri

from softhand_model.effects import Effect
from softhand_model.model_file import Model
from softhand_trials.trials import MASS_SPREAD, OFFSET, Placement


@dataclass(frozen=True)
class Randomisation:
    """Ranges from which each episode draws.

    Attributes:
        offset: largest shift of the object in x and in y [m], uniform.
        yaw: largest turn of the object about the vertical [rad], uniform.
        mass_spread: largest change of the object's mass, as a share [-], uniform.
        friction: least and largest factor [-] on the friction of all pairs, uniform in its
            logarithm; `FrictionTable.rubber_range` is what published values of rubber allow.
        model: whether effects' parameters are drawn from the normal distribution with the standard
            errors that `model-lab add` wrote into the model file, cut at the parameters' bounds.
            The file has no correlations: parameters are drawn independently.

    Raises:
        ValueError: a range is negative or empty.
    """

    offset: float = OFFSET
    yaw: float = 0.0
    mass_spread: float = MASS_SPREAD
    friction: tuple[float, float] = (1.0, 1.0)
    model: bool = True

    def __post_init__(self) -> None:
        for name, most in (("offset", math.inf), ("yaw", math.inf), ("mass_spread", 1.0)):
            value = getattr(self, name)
            if not 0.0 <= value < most:
                raise ValueError(f"{name}: expected 0 or more and less than {most}, got {value!r}")
        low, high = self.friction
        if not 0.0 < low <= high < math.inf:
            raise ValueError(f"friction: expected two factors above 0, got {self.friction!r}")

    def placement(self, generator: np.random.Generator) -> Placement:
        """Place, mass and friction of the object in the next episode."""
        x, y, mass, yaw = generator.uniform(-1.0, 1.0, 4).tolist()
        friction = math.exp(generator.uniform(*np.log(self.friction)))
        return Placement(
            offset=(self.offset * x, self.offset * y),
            mass_scale=1.0 + self.mass_spread * mass,
            yaw=self.yaw * yaw,
            friction_scale=friction,
        )

    def draws(self, model: Model) -> bool:
        """Whether a model has parameters that are drawn."""
        return self.model and any(error > 0 for std in model.std.values() for error in std.values())


def drawn(model: Model, generator: np.random.Generator) -> Model:
    """The model with its effects' parameters drawn from their normal distributions.

    >>> from softhand_model.effects import effect_classes
    >>> gravity_class = effect_classes()["gravity"]
    >>> gravity = gravity_class(mass_scale=1.0)
    >>> model = Model(effects=(gravity,), std={"gravity": {"mass_scale": 0.1}})
    >>> scales = [drawn(model, np.random.default_rng(k)).gravity_scale for k in range(200)]
    >>> bool(abs(np.mean(scales) - 1.0) < 0.03 and abs(np.std(scales) - 0.1) < 0.02)
    True
    """
    effects = (_drawn_effect(e, model.std.get(e.name, {}), generator) for e in model.effects)
    return replace(model, effects=tuple(effects))


def _drawn_effect(
    effect: Effect, std: Mapping[str, float], generator: np.random.Generator
) -> Effect:
    values = dict(effect.values)
    for parameter in effect.parameters:
        mean, error = values[parameter.name], std.get(parameter.name, 0.0)
        if error > 0.0:
            low, high = ndtr((np.array([parameter.low, parameter.high]) - mean) / error)
            value = mean + error * ndtri(generator.uniform(low, high))
            values[parameter.name] = float(np.clip(value, parameter.low, parameter.high))
    return type(effect)(**values)
