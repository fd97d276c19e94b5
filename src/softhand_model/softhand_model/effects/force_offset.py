"""A force gauge whose zero is off."""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar

from softhand_model.effects.effect import Parameter
from softhand_model.effects.stages import Array, Memory, OutputEffect


class ForceOffset(OutputEffect):
    """The gauge reads too much or too little everywhere: y_read = y + offset."""

    name = "force_offset"
    experiments = frozenset({"blocked_tip"})
    quantity = "tip_force"
    parameters = (
        Parameter(
            "offset",
            "N",
            -10.0,
            10.0,
            "reading without force",
            typical=(-0.15, 0.15),
            neutral=0.0,
        ),
    )
    unseen_in: ClassVar[Mapping[str, str]] = dict.fromkeys(
        ("free_bending", "uniaxial"), "no force is measured"
    )
    confounded_with: ClassVar[Mapping[str, str]] = {
        "pressure_offset": "one with it as far as the force is proportional to the pressure",
    }
    rank = 1

    def reading(self, value: Array, memory: Memory, dt: Array | float) -> Array:
        """Reading [N]."""
        return value + self.values["offset"]
