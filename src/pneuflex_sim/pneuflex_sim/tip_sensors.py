"""What the angle sensors at the actuators' tips show under the effects of a model."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from softhand_model.effects.staged import StagedEffects
from softhand_model.model_file import Model

QUANTITY = "tip_angle"


class TipSensors:
    """One sensor an actuator, with the memory of the model's output effects.

    active: whether the model has effects that act on it; else readings are the true angles.
    """

    def __init__(self, model: Model) -> None:
        self._model = model
        self.active = any(
            getattr(effect, "quantity", "") == QUANTITY for effect in model.stage("output")
        )
        self.reset()

    def reset(self) -> None:
        """Forget everything: straight for long."""
        self._sensors: dict[str, StagedEffects] = {}
        self._readings: dict[str, float] = {}

    def step(self, dt: float, angles: Mapping[str, float]) -> None:
        """Advance the sensors by dt [s] to the true angles [rad] at its end, by actuator."""
        for name, angle in angles.items():
            sensor = self._sensors.setdefault(name, StagedEffects(self._model.stage("output")))
            self._readings[name] = float(sensor.reading(QUANTITY, np.asarray(angle), dt))

    def readings(self, angles: Mapping[str, float]) -> dict[str, float]:
        """Readings [rad] by actuator after the last step; before the first one those of a step that
        takes no time to the true angles [rad].
        """
        if not self.active:
            return dict(angles)
        if not self._readings:
            self.step(0.0, angles)
        return dict(self._readings)
