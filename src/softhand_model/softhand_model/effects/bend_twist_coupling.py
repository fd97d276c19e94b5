"""A finger that twists when it is bent sideways."""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar

from softhand_model.effects.effect import NO_PRESSURE, Parameter
from softhand_model.effects.stages import Array, StructureEffect


class BendTwistCoupling(StructureEffect):
    """Lateral bending (about x) and twist (about z) of a joint are coupled: the off-diagonal of its
    stiffness is k45 times that in bending.

    abs(k45) < sqrt(k_lateral*k_torsion)/B, which is 1 where all three axes have the same stiffness,
    or the springs would give way. The thesis leaves the couplings out "for want of a model" (5.1.1)
    and finds its twist torque wrong (section 5.2.4).
    """

    name = "bend_twist_coupling"
    experiments = frozenset({"base_torque"})
    parameters = (
        Parameter(
            "k45",
            "",
            -0.95,
            0.95,
            "stiffness between lateral bending and twist over that in bending",
            typical=(0.1, 0.6),
            neutral=0.0,
        ),
    )
    unseen_in: ClassVar[Mapping[str, str]] = {
        **NO_PRESSURE,
        "free_bending": "a finger that bends in its plane neither twists nor bends sideways",
        "blocked_tip": "a finger that is blocked in its plane neither twists nor bends sideways",
    }

    def bend_twist_coupling(self) -> Array | float:
        """Off-diagonal of lateral bending and twist over B [-]."""
        return self.values["k45"]
