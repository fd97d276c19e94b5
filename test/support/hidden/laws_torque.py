"""Laws of the torque on the base: joints that couple and slacken, and a sensor's crosstalk."""

from __future__ import annotations

import numpy as np

from hidden.laws import law
from hidden.plant import Plant


@law("bend_twist_coupling", ("k45", 0.01, 0.7), signed=True)
def bend_twist_coupling(plant: Plant, k45: float) -> None:
    """A finger that twists when it is bent sideways."""
    plant.bend_twist = k45


@law("passive_layer_slack", ("ratio", 0.99, 0.15))
def passive_layer_slack(plant: Plant, ratio: float) -> None:
    """A passive layer that hangs loose while it is straightened."""
    plant.slack = ratio


@law("crosstalk", ("share", 0.005, 0.8), signed=True)
def crosstalk(plant: Plant, share: float) -> None:
    """A torque sensor whose axes answer to one another."""
    plant.mixing.append(np.eye(3) + share * np.array([[0, 1, 0], [0, 0, -1], [1, 0, 0]]))
