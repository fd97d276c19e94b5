"""A chamber that first grows round before it bends the finger."""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar

import numpy as np

from softhand_model.effects.effect import BENDING, NO_PRESSURE, Parameter
from softhand_model.effects.stages import Array, LoadEffect, SectionShape


class SectionRounding(LoadEffect):
    """Empirical: load s*(1 - gain*exp(-max(p, 0)/pressure_scale)).

    At low pressure the section rounds instead of bending the finger. One guess at why the thesis's
    actuator with a wall of 5.5 mm is stiffer at low pressure; it leaves the cause open (section
    5.2.2).
    """

    name = "section_rounding"
    experiments = BENDING
    parameters = (
        Parameter(
            "gain",
            "",
            0.0,
            0.99,
            "share of the load that is lost at no pressure",
            typical=(0.05, 0.6),
            neutral=0.0,
        ),
        Parameter(
            "pressure_scale",
            "Pa",
            100.0,
            1e6,
            "pressure over which the section becomes round",
            typical=(3e3, 40e3),
            logarithmic=True,
        ),
    )
    unseen_in: ClassVar[Mapping[str, str]] = NO_PRESSURE
    confounded_with: ClassVar[Mapping[str, str]] = {
        "dead_zone": "alike at low pressure",
        "thick_wall": "alike on one wall thickness: specimens of several tell them apart",
        "actuation_nonlinearity": "alike on one wall thickness",
    }

    def act_on_load(self, load: Array, pressure: Array, shape: SectionShape) -> Array:
        """Load [-] that bends."""
        gone = np.exp(-np.maximum(pressure, 0.0) / self.values["pressure_scale"])
        return load * (1.0 - self.values["gain"] * gone)
