"""Elastic effects without memory: factors on the neo-Hookean stress."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar

import numpy as np

from softhand_common.numerics.arrays import Array, Flags
from softhand_common.numerics.compiled import compiled
from softhand_model.effects.effect import (
    BENDING,
    POSED,
    RUBBER,
    STRETCHED,
    Parameter,
    unseen_when_stretched,
)
from softhand_model.effects.kernel import HEIGHT, WALL, Kernel, Trial, invariant
from softhand_model.effects.stages import ElasticEffect, Memory, SectionShape, Strain

ALMOST = 0.99  # of jm, from where the factor goes on in a straight line and so stays finite
STRETCH_SCALE = 0.25  # over which the excess fades
LARGEST_EXCESS = 3.0  # gain*(2d/h)**2, from where the elastic side would fall


@compiled
def locking_factor(share: Any) -> Any:
    """Gent's factor [-] 1/(1 - share), where share [-] is J1 divided by the J1 at which the rubber
    locks; above a share of ALMOST it is continued as a straight line.
    """
    below = 1.0 / (1.0 - np.minimum(share, ALMOST))
    return below + np.maximum(share - ALMOST, 0.0) / (1.0 - ALMOST) ** 2


@compiled
def _gent(stress: Array, trial: Trial, values: Array, state: Array) -> None:
    for lane in range(len(stress)):
        share = invariant(trial.stretch[lane], trial.mode) / values[0, lane]
        stress[lane] *= locking_factor(share)


class GentStiffening(ElasticEffect):
    """Gent's limit of extension: factor 1/(1 - J1/jm) (eq. 3.45).

    jm [-] is the invariant J1 at which the rubber locks. ERRATUM: 3.45 prints the energy without
    its minus sign; W = -(G/2)*Jm*log(1 - J1/Jm) gives this factor.
    """

    name = "gent_stiffening"
    cause, member = "stiffening", "Gent"
    experiments = RUBBER | POSED
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
    kernel = Kernel(_gent)

    def stress(
        self, stress: Array, strain: Strain, shape: SectionShape, memory: Memory, dt: Array | float
    ) -> Array:
        """Stress [-] (divided by the shear modulus) times the factor of this effect."""
        return stress * locking_factor.py_func(strain.invariant / self.values["jm"])


@compiled
def _yeoh(stress: Array, trial: Trial, values: Array, state: Array) -> None:
    for lane in range(len(stress)):
        stress[lane] *= 1.0 + 2.0 * values[0, lane] * invariant(trial.stretch[lane], trial.mode)


class YeohStiffening(ElasticEffect):
    """Second term of Yeoh's energy: factor 1 + 2*c2*J1, c2 = C20/C10 (section 3.4.6).

    Silicones have about C20 = C10/500 there.
    """

    name = "yeoh_stiffening"
    cause, member = "stiffening", "Yeoh"
    experiments = RUBBER | POSED
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
    kernel = Kernel(_yeoh)

    def stress(
        self, stress: Array, strain: Strain, shape: SectionShape, memory: Memory, dt: Array | float
    ) -> Array:
        """Stress [-] (divided by the shear modulus) times the factor of this effect."""
        return stress * (1.0 + 2.0 * self.values["c2"] * strain.invariant)


class YeohThirdOrder(ElasticEffect):
    """Third term of Yeoh's energy: 3*c3*J1**2 added to the factor of `yeoh_stiffening`, c3 =
    C30/C10.

    (O. H. Yeoh, Rubber Chem. Technol. 66, 1993.) Together with `yeoh_stiffening` the stress is q*(1
    + 2*c2*J1 + 3*c3*J1**2).
    """

    name = "yeoh_third_order"
    cause, member = "stiffening", "Yeoh of third order"
    experiments = RUBBER | POSED
    refines = ("yeoh_stiffening", "gent_stiffening")
    rank = 1  # behind the factors, so that both terms of Yeoh add up
    parameters = (
        Parameter(
            "c3",
            "",
            1e-7,
            5.0,
            "third coefficient of the energy over the first",
            (1e-4, 0.05),
            logarithmic=True,
        ),
    )
    confounded_with: ClassVar[Mapping[str, str]] = {
        "gent_stiffening": "both stiffen at large strain"
    }

    def stress(
        self, stress: Array, strain: Strain, shape: SectionShape, memory: Memory, dt: Array | float
    ) -> Array:
        """Stress [-] (divided by the shear modulus) with the third term added."""
        return stress + 3.0 * self.values["c3"] * strain.invariant**2 * strain.elastic_term


class ArrudaBoyce(ElasticEffect):
    """Rubber as eight chains of finite length: factor L(x)/x over L(x0)/x0, x = sqrt((J1 +
    3)/(3*links)), x0 = 1/sqrt(links), with the inverse Langevin function L.

    (E. M. Arruda, M. C. Boyce, J. Mech. Phys. Solids 41, 1993.) The chains are straight at J1 =
    3*(links - 1); G is the modulus at zero strain. L is approximated within 0.3 % (M. Kroeger, J.
    Non-Newtonian Fluid Mech. 223, 2015).
    """

    name = "arruda_boyce"
    cause, member = "stiffening", "Arruda-Boyce"
    experiments = RUBBER | POSED
    refines = ("gent_stiffening", "yeoh_stiffening")
    parameters = (
        Parameter(
            "links",
            "",
            1.2,
            1000.0,
            "links of a chain; the square of its largest stretch",
            (2.0, 60.0),
            logarithmic=True,
        ),
    )
    confounded_with: ClassVar[Mapping[str, str]] = {
        "gent_stiffening": "nearly one with it at jm = 3*(links - 1): both are the chains' limit"
    }

    def stress(
        self, stress: Array, strain: Strain, shape: SectionShape, memory: Memory, dt: Array | float
    ) -> Array:
        """Stress [-] (divided by the shear modulus) times the factor of this effect."""
        rest = 1.0 / self.values["links"]
        share = (1.0 + strain.invariant / 3.0) * rest  # x**2
        below = np.minimum(share, ALMOST)
        factor = chain_force(below) + (share - below) * CHAIN_SLOPE
        return stress * (factor / chain_force(rest))


def chain_force(square: Array) -> Array:
    """Inverse Langevin function of x over x [-], given x**2 below 1.

    >>> float(chain_force(np.array(0.0))), round(float(chain_force(np.array(0.81))), 1)
    (3.0, 11.1)
    """
    return (3.0 - 0.2 * square * (6.0 + square * (1.0 - 2.0 * square))) / (1.0 - square)


CHAIN_SLOPE = float((chain_force(np.array(ALMOST)) - chain_force(np.array(ALMOST - 1e-6))) / 1e-6)


class Ogden(ElasticEffect):
    """One term of Ogden's energy: (2*G/a**2)*(sum of the principal stretches**a - 3) with the
    exponent a; a = 2 is the base model.

    (R. W. Ogden, Proc. R. Soc. Lond. A 326, 1972.) Stress (2*G/a)*(lambda**(a - 1) - lambda**(-c -
    1)) with c = a/2 in uniaxial tension, a in pure shear, 2*a in equibiaxial tension.
    """

    name = "ogden"
    cause, member = "stiffening", "Ogden"
    experiments = RUBBER | POSED
    bases = frozenset({"pneuflex"})
    refines = ("yeoh_stiffening", "gent_stiffening", "mooney_rivlin")
    parameters = (Parameter("exponent", "", 1.0, 12.0, "exponent", (1.2, 4.0), neutral=2.0),)
    confounded_with: ClassVar[Mapping[str, str]] = {
        "yeoh_stiffening": "alike at moderate strain if the exponent is above 2",
        "second_invariant": "alike in one mode of tension if it is below",
    }

    def stress(
        self, stress: Array, strain: Strain, shape: SectionShape, memory: Memory, dt: Array | float
    ) -> Array:
        """Stress [-] (divided by the shear modulus) times the factor of this effect."""
        return stress * power_stress(strain, self.values["exponent"])


ACROSS = {"uniaxial": 0.5, "pure_shear": 1.0, "equibiaxial": 2.0}
"""Logarithm of the stretch of a direction that gives way / that of the imposed one, negative."""


def power_stress(strain: Strain, exponent: Array | float) -> Array:
    """Stress of one term of Ogden's energy divided by that of the base model [-], also in the
    limit of zero strain.

    >>> [float(power_stress(Strain(np.array(x)), a)) for x, a in ((1.0, 3.0), (2.0, 2.0))]
    [1.0, 1.0]
    """
    across, logarithm = ACROSS[strain.mode], np.log(strain.stretch)
    fading = np.exp((exponent - 2.0) * -across * logarithm)
    every = (1.0 + across) * logarithm
    return fading * _mean_growth(exponent * every) / _mean_growth(2.0 * every)


def _mean_growth(total: Array) -> Array:
    """(exp(x) - 1)/x, also at 0."""
    small = np.abs(total) < 1e-9
    safe = np.where(small, 1.0, total)
    return np.where(small, 1.0 + 0.5 * total, np.expm1(safe) / safe)


class MooneyRivlin(ElasticEffect):
    """Second term of Mooney and Rivlin: energy (G/2)*(J1 + b*J2)/(1 + b) with b = C01/C10; G is the
    shear modulus of both terms together (section 3.4.6).

    Factor (1 + b/lambda)/(1 + b) in uniaxial, (1 + b*lambda**2)/(1 + b) in equibiaxial tension. In
    bending the rubber is in pure shear, where J1 = J2 (eq. 3.18): the factor is 1.
    """

    name = "mooney_rivlin"
    experiments = STRETCHED
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
        """Stress [-] (divided by the shear modulus) times the factor of this effect."""
        ratio = self.values["c01_ratio"]
        return stress * ((1.0 + ratio * strain.second) / (1.0 + ratio))


class SecondInvariant(ElasticEffect):
    """The second invariant of the logarithmic strain in addition to J1: the energy (G/2)*(J1 +
    2*r*(sum of the squared logarithms of the principal stretches))/(1 + r).

    Entangled chains confine each other as in a tube, which stiffens the rubber at small strain more
    than at large. It is the limit b -> 0 of the tube's energy, the sum of the stretches**-b (M.
    Kaliske, G. Heinrich, Rubber Chem. Technol. 72, 1999); b = 2 is `mooney_rivlin`. Factor (1 +
    r*t)/(1 + r), t the factor of `ogden` at the exponent 0. In bending it softens.
    """

    name = "second_invariant"
    experiments = RUBBER | POSED
    bases = frozenset({"pneuflex"})
    refines = ("mooney_rivlin",)
    parameters = (
        Parameter(
            "ratio",
            "",
            1e-3,
            5.0,
            "modulus of that part over the other at no strain",
            (0.05, 2.0),
            logarithmic=True,
        ),
    )
    confounded_with: ClassVar[Mapping[str, str]] = {
        "mooney_rivlin": "the same to first order: equibiaxial tension tells",
        "ogden": "alike in one mode of tension",
    }

    def stress(
        self, stress: Array, strain: Strain, shape: SectionShape, memory: Memory, dt: Array | float
    ) -> Array:
        """Stress [-] (divided by the shear modulus) times the factor of this effect."""
        ratio = self.values["ratio"]
        return stress * ((1.0 + ratio * power_stress(strain, 0.0)) / (1.0 + ratio))


@compiled
def thickness(wall: Any, height: Any) -> Any:
    """min(2*wall/height, 1)**2 [-]."""
    return np.minimum(2.0 * wall / height, 1.0) ** 2


@compiled
def fading(stretch: Any) -> Any:
    """Share [-] of the excess stiffness of a thick wall that is left at a stretch [-]: exp(-(lambda
    - 1)/0.25).
    """
    return np.exp((1.0 - stretch) / STRETCH_SCALE)


@compiled
def _thick_wall(stress: Array, trial: Trial, values: Array, state: Array) -> None:
    for lane in range(len(stress)):
        share = thickness(trial.sizes[WALL, lane], trial.sizes[HEIGHT, lane])
        stress[lane] *= 1.0 + values[0, lane] * share * fading(trial.stretch[lane])


class ThickWall(ElasticEffect):
    """Empirical: factor 1 + gain*min(2*d/h, 1)**2*exp(-(lambda - 1)/0.25).

    A thick wall is stiffer at small bending than the membrane of eq. 3.21. The form is a guess at
    why the finger of section 5.2.2 deviates, like `section_rounding`. gain*(2*d/h)**2 must not
    exceed 3.
    """

    name = "thick_wall"
    experiments = BENDING | POSED
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
    unseen_in: ClassVar[Mapping[str, str]] = unseen_when_stretched(
        "a strip in tension has no wall to bend"
    )
    confounded_with: ClassVar[Mapping[str, str]] = {
        "section_rounding": "alike on one wall thickness: specimens of several tell them apart",
        "actuation_nonlinearity": "alike on one wall thickness",
    }
    kernel = Kernel(_thick_wall)

    def stress(
        self, stress: Array, strain: Strain, shape: SectionShape, memory: Memory, dt: Array | float
    ) -> Array:
        """Stress [-] (divided by the shear modulus) times the factor of this effect."""
        return stress * (1.0 + self._excess(shape) * fading.py_func(strain.stretch))

    def allows(self, shape: SectionShape) -> Flags | bool:
        """Whether gain*(2*d/h)**2 is at most 3 at the sections."""
        return self._excess(shape) <= LARGEST_EXCESS

    def _excess(self, shape: SectionShape) -> Array:
        return self.values["gain"] * thickness.py_func(shape.wall, shape.height)
