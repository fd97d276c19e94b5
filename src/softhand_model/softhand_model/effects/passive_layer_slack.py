"""A passive layer that hangs loose while the finger is pushed straight."""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar

import numpy as np

from softhand_model.effects.effect import NO_PRESSURE, Parameter
from softhand_model.effects.stages import Array, StructureEffect


class PassiveLayerSlack(StructureEffect):
    """Stiffness times ratio where the curvature is below the free one.

    A passive layer that carries no tension lets go when the finger is straightened; the thesis
    suspects it behind a torque that is overestimated in one direction only (section 5.2.4).
    """

    name = "passive_layer_slack"
    experiments = frozenset({"blocked_tip", "base_torque"})
    parameters = (
        Parameter(
            "ratio",
            "",
            0.02,
            1.0,
            "stiffness against straightening over that against bending further",
            typical=(0.3, 0.95),
            neutral=1.0,
        ),
    )
    unseen_in: ClassVar[Mapping[str, str]] = {
        **NO_PRESSURE,
        "free_bending": "nothing straightens a finger that bends freely",
    }
    confounded_with: ClassVar[Mapping[str, str]] = {
        "pressure_gain": "one with it at small loads of a blocked tip",
    }

    def stiffness_factor(self, bend: Array, rest: Array) -> Array:
        """Factor [-]: the ratio where bend is below rest."""
        return np.where(bend < rest, self.values["ratio"], 1.0)
