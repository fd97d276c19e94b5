"""Elastic effects without memory: factors on the neo-Hookean stress."""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar

import numpy as np

from softhand_model.effects.effect import BENDING, RUBBER, Parameter
from softhand_model.effects.stages import ElasticEffect, Memory, SectionShape, Strain
from softhand_model.numerics.arrays import Array, Flags

ALMOST = 0.99  # of jm, from where the factor goes on in a straight line and so stays finite
STRETCH_SCALE = 0.25  # over which the excess fades
LARGEST_EXCESS = 3.0  # gain*(2d/h)**2, from where the elastic side would fall


class GentStiffening(ElasticEffect):
    """Gent's limit of extension: factor 1/(1 - J1/jm) (eq. 3.45).

    jm [-] is the invariant J1 at which the rubber locks. ERRATUM: 3.45 prints the energy without
    its minus sign; W = -(G/2)*Jm*log(1 - J1/Jm) gives this factor.
    """

    name = "gent_stiffening"
    experiments = RUBBER
    parameters = (
        Parameter(
            "jm",
            "",
            0.5,
            1000.0,
            "invariant J1 at which the rubber locks",
            (2.0, 60.0),
            logarithmic=True,
        ),
    )
    confounded_with: ClassVar[Mapping[str, str]] = {
        "yeoh_stiffening": "the same to first order, c2 = 1/(2*jm): only large strain tells"
    }

    def stress(
        self, stress: Array, strain: Strain, shape: SectionShape, memory: Memory, dt: Array | float
    ) -> Array:
        """Stress [-] times the factor."""
        share = strain.invariant / self.values["jm"]
        below = 1.0 / (1.0 - np.minimum(share, ALMOST))
        return stress * (below + np.maximum(share - ALMOST, 0.0) / (1.0 - ALMOST) ** 2)


class YeohStiffening(ElasticEffect):
    """Second term of Yeoh's energy: factor 1 + 2*c2*J1, c2 = C20/C10 (section 3.4.6).

    Silicones have about C20 = C10/500 there.
    """

    name = "yeoh_stiffening"
    experiments = RUBBER
    parameters = (
        Parameter(
            "c2",
            "",
            1e-5,
            5.0,
            "second coefficient of the energy over the first",
            (0.005, 0.2),
            logarithmic=True,
        ),
    )
    confounded_with: ClassVar[Mapping[str, str]] = {
        "gent_stiffening": "the same to first order, jm = 1/(2*c2): only large strain tells"
    }

    def stress(
        self, stress: Array, strain: Strain, shape: SectionShape, memory: Memory, dt: Array | float
    ) -> Array:
        """Stress [-] times the factor."""
        return stress * (1.0 + 2.0 * self.values["c2"] * strain.invariant)


class MooneyRivlin(ElasticEffect):
    """Second term of Mooney and Rivlin: factor (1 + b/lambda)/(1 + b) in uniaxial tension, b =
    C01/C10; the shear modulus is that of both terms together (section 3.4.6).

    In bending the rubber is in pure shear, where J1 = J2 (eq. 3.18): the factor is 1.
    """

    name = "mooney_rivlin"
    experiments = frozenset({"uniaxial"})
    bases = frozenset({"pneuflex"})
    parameters = (
        Parameter("c01_ratio", "", 1e-4, 50.0, "C01 over C10", (0.05, 3.0), logarithmic=True),
    )
    unseen_in: ClassVar[Mapping[str, str]] = dict.fromkeys(
        sorted(BENDING), "changes nothing in bending, where J1 = J2"
    )
    confounded_with: ClassVar[Mapping[str, str]] = {
        "modulus_scale": "at large stretch it acts as a lower modulus"
    }

    def stress(
        self, stress: Array, strain: Strain, shape: SectionShape, memory: Memory, dt: Array | float
    ) -> Array:
        """Stress [-] times the factor."""
        if strain.mode != "uniaxial":
            return stress
        ratio = self.values["c01_ratio"]
        return stress * ((1.0 + ratio / strain.stretch) / (1.0 + ratio))


class ThickWall(ElasticEffect):
    """Empirical: factor 1 + gain*min(2*d/h, 1)**2*exp(-(lambda - 1)/0.25).

    A thick wall is stiffer at small bending than the membrane of eq. 3.21: another guess at the
    riddle of section 5.2.2 (`section_rounding`). gain*(2*d/h)**2 must not exceed 3.
    """

    name = "thick_wall"
    experiments = BENDING
    bases = frozenset({"pneuflex"})
    parameters = (
        Parameter(
            "gain",
            "",
            0.0,
            300.0,
            "excess of the stiffness at no strain and d = h/2",
            (0.3, 8.0),
            neutral=0.0,
        ),
    )
    unseen_in: ClassVar[Mapping[str, str]] = {"uniaxial": "a strip in tension has no wall to bend"}
    confounded_with: ClassVar[Mapping[str, str]] = {
        "section_rounding": "alike on one wall thickness: specimens of several tell them apart",
        "actuation_nonlinearity": "alike on one wall thickness",
    }

    def stress(
        self, stress: Array, strain: Strain, shape: SectionShape, memory: Memory, dt: Array | float
    ) -> Array:
        """Stress [-] times the factor."""
        return stress * (1.0 + self._excess(shape) * np.exp((1.0 - strain.stretch) / STRETCH_SCALE))

    def allows(self, shape: SectionShape) -> Flags | bool:
        """Whether the excess is within its limit."""
        return self._excess(shape) <= LARGEST_EXCESS

    def _excess(self, shape: SectionShape) -> Array:
        return self.values["gain"] * np.minimum(2.0 * shape.wall / shape.height, 1.0) ** 2
