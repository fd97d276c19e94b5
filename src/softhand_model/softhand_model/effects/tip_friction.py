"""A fingertip that sticks to its gauge."""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar

import numpy as np

from softhand_model.effects.effect import Parameter
from softhand_model.effects.stages import Array, Memory, StructureEffect

UNCHANGED = 1e-7  # of the force: less is rounding, not motion


class TipFriction(StructureEffect):
    """The gauge sees F*(1 - coefficient*sign(dF/dt)): friction holds against what changes."""

    name = "tip_friction"
    experiments = frozenset({"blocked_tip"})
    parameters = (
        Parameter(
            "coefficient",
            "",
            0.0,
            0.9,
            "share of the force that friction takes or holds",
            typical=(0.03, 0.5),
            neutral=0.0,
        ),
    )
    unseen_in: ClassVar[Mapping[str, str]] = dict.fromkeys(
        ("free_bending", "uniaxial", "base_torque"), "nothing rubs at the tip"
    )
    confounded_with: ClassVar[Mapping[str, str]] = {
        "hysteresis": "both part loading from unloading: friction jumps when the force turns",
    }
    has_memory = True

    def tip_force(self, force: Array, memory: Memory, dt: Array | float) -> Array:
        """Force [N] that reaches the gauge."""
        change = force - memory.get("force", 0.0)
        memory["force"] = force
        direction = np.sign(change) * (np.abs(change) > UNCHANGED * np.abs(force))
        return force * (1.0 - self.values["coefficient"] * direction)
