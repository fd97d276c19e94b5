"""A force gauge that yields."""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar

from softhand_model.effects.effect import Parameter
from softhand_model.effects.stages import Array, StructureEffect


class GaugeCompliance(StructureEffect):
    """The blocked tip moves by F/stiffness, as the gauge or its holder gives way."""

    name = "gauge_compliance"
    experiments = frozenset({"blocked_tip"})
    parameters = (
        Parameter(
            "stiffness",
            "N/m",
            1.0,
            1e7,
            "force over the way by which the tip yields",
            typical=(30.0, 3e3),
            logarithmic=True,
        ),
    )
    unseen_in: ClassVar[Mapping[str, str]] = dict.fromkeys(
        ("free_bending", "uniaxial", "base_torque"), "there is no force gauge at the tip"
    )
    confounded_with: ClassVar[Mapping[str, str]] = {
        "modulus_scale": "a soft gauge makes the force depend on the modulus",
        "pressure_gain": "alike where the force is proportional to the pressure",
    }

    def tip_compliance(self) -> Array | float:
        """What the tip yields under its force [m/N]."""
        return 1.0 / self.values["stiffness"]
