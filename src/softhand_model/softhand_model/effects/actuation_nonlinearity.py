"""The approximation of the thesis, with its own numbers, in place of the exact curvature."""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar

from softhand_model import section
from softhand_model.effects.effect import NO_PRESSURE, Parameter
from softhand_model.effects.stages import Array, SectionShape, StructureEffect


class ActuationNonlinearity(StructureEffect):
    """Free curvature by eq. 5.2 and 5.3 with a and p0 of one's own instead of the exact form.

    kappa = p*ratio/(8*G*d)*(1/sqrt(a) + p/sqrt(p**2/(a - 1) + (a - 1)*p0**2)): the thesis's remedy
    for its actuator with the 5.5 mm wall, where a larger a mends the curve (section 5.2.2). What
    acts on load and elastic side does not act on it. A blocked tip has no free curvature but with
    linear springs.
    """

    name = "actuation_nonlinearity"
    experiments = frozenset({"free_bending", "base_torque"})
    parameters = (
        Parameter(
            "a",
            "",
            1.01,
            100.0,
            "square of the initial slope's fall: 4 for the rubber of eq. 3.21",
            typical=(2.0, 16.0),
            logarithmic=True,
        ),
        Parameter(
            "p0",
            "Pa",
            100.0,
            1e7,
            "pressure of the transition: 0.90*8*G*d/h for the rubber of eq. 3.21",
            typical=(1e4, 2.5e5),
            logarithmic=True,
        ),
    )
    unseen_in: ClassVar[Mapping[str, str]] = {
        **NO_PRESSURE,
        "blocked_tip": "the exact balance has no free curvature to replace",
    }
    confounded_with: ClassVar[Mapping[str, str]] = {
        "thick_wall": "alike on one wall thickness",
        "section_rounding": "alike on one wall thickness",
    }

    def act_on_curvature(self, curvature: Array, pressure: Array, shape: SectionShape) -> Array:
        """Free curvature [1/m] by the approximation."""
        rule = section.rule_actuation_ratio(shape.wall, shape.shear_modulus)
        relative = rule * shape.height
        shown = section.printed_nonlinearity(
            pressure * relative, self.values["a"], self.values["p0"] * relative
        )
        return pressure * rule * shape.ratio * shown
