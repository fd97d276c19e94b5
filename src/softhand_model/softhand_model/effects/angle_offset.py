"""An angle sensor whose zero is off."""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar

from softhand_model.effects.effect import Parameter
from softhand_model.effects.stages import Array, Memory, OutputEffect


class AngleOffset(OutputEffect):
    """The tip's angle reads too much or too little everywhere: y_read = y + offset."""

    name = "angle_offset"
    experiments = frozenset({"free_bending"})
    quantity = "tip_angle"
    parameters = (
        Parameter(
            "offset",
            "rad",
            -1.5,
            1.5,
            "reading of a straight finger",
            typical=(-0.15, 0.15),
            neutral=0.0,
        ),
    )
    unseen_in: ClassVar[Mapping[str, str]] = dict.fromkeys(
        ("blocked_tip", "uniaxial"), "no angle is measured"
    )
    confounded_with: ClassVar[Mapping[str, str]] = {
        "pressure_offset": "alike as far as the curve is straight",
    }
    rank = 1

    def reading(self, value: Array, memory: Memory, dt: Array | float) -> Array:
        """Reading [rad]."""
        return value + self.values["offset"]
