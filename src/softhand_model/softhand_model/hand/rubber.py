"""Rubbers: strain measures, strain through a wall, limits of the neo-Hookean model, and which
rubber is suitable.

Within a wall (section 3.4.5) depths and curvatures are relative to the height h: depth = d/h [-]
counts from the outer face of the undeformed wall, bend = kappa*h [-].
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from softhand_common.documents.yaml_document import Node, read_document
from softhand_common.numerics.arrays import Array
from softhand_model.data_files import data_file
from softhand_model.hand import plausible
from softhand_model.hand.section import SECTION_NEWTON_STEPS

FORMAT = "softhand-rubbers/1"
USEFUL_STRETCH = (0.3, 0.5)  # stretch in use over the largest one (section 3.3.3)
PASCAL_PER_KILOPASCAL = 1e3


@dataclass(frozen=True)
class Rubber:
    """A rubber: largest stretch [-] and shear modulus [Pa] as in Table 3.2, density [kg/m3]."""

    name: str
    maker: str
    chemistry: str
    max_stretch: float
    shear_modulus: float
    density: float

    @property
    def suitability(self) -> float:
        """Suitability index [kPa**0.25] (eq. 3.10)."""
        return float(suitability(self.max_stretch, self.shear_modulus))


def load_rubbers(path: Path | None = None) -> dict[str, Rubber]:
    """The rubbers of data/rubbers.yaml or another file of its format, by name.

    path: the file; None: data/rubbers.yaml. Raises ValueError for a file that is not valid; the
    message has file, key, what was expected and what came.

    >>> round(load_rubbers()["Dragon Skin 10"].suitability, 1)
    26.6
    """
    document = read_document(path or data_file("rubbers.yaml"), FORMAT)
    rubbers = document.fields(["format", "rubbers"])["rubbers"].mapping()
    return {name: _rubber(name, node) for name, node in rubbers.items()}


def _rubber(name: str, node: Node) -> Rubber:
    fields = node.fields(["maker", "chemistry", "max_stretch", "shear_modulus", "density"])
    return Rubber(
        name,
        fields["maker"].text(),
        fields["chemistry"].text(),
        fields["max_stretch"].number(above=1.0, high=100.0),
        fields["shear_modulus"].within(plausible.SHEAR_MODULUS),
        fields["density"].within(plausible.DENSITY),
    )


def suitability(max_stretch: ArrayLike, shear_modulus: ArrayLike) -> Array:
    """Suitability index S = (lambda_max - 1)*G**0.25 [kPa**0.25], G given in [Pa] (eq. 3.10).

    ERRATUM: for Elastosil M4125 Table 3.2 prints a largest stretch of 6, which gives 21.4; its 23.5
    needs 6.5.

    >>> [round(float(suitability(stretch, 333e3)), 1) for stretch in (6.0, 6.5)]
    [21.4, 23.5]
    """
    modulus = np.asarray(shear_modulus, float) / PASCAL_PER_KILOPASCAL
    return (np.asarray(max_stretch, float) - 1.0) * modulus**0.25


def suitability_by_tear_strength(max_stretch: ArrayLike, tear_strength: ArrayLike) -> Array:
    """Suitability index [kPa**0.25] from the largest tensile load [Pa] (eq. 3.11).

    Equals eq. 3.10 where the load grows linearly, sigma_max = G*(lambda_max - 1).
    """
    strain = np.asarray(max_stretch, float) - 1.0
    return suitability(max_stretch, np.asarray(tear_strength, float) / strain)


def strain_invariant(stretch: ArrayLike) -> Array:
    """J1 = J2 = lambda**2 + lambda**-2 - 2 [-] of pure shear, as in the actuator's top (eq. 3.18).

    >>> round(float(strain_invariant(3.0)), 3)
    7.111
    """
    stretch = np.asarray(stretch, float)
    return stretch**2 + stretch**-2.0 - 2.0


def gent_factor(stretch: ArrayLike, jm: float) -> Array:
    """Stress of a Gent solid over that of the neo-Hookean one [-]: 1/(1 - J1/jm) (eq. 3.45).

    >>> round(float(gent_factor(3.0, 100.0)), 4)
    1.0766
    """
    return 1.0 / (1.0 - strain_invariant(stretch) / jm)


def mooney_rivlin_energy_error(stretch: ArrayLike, c01: float = 0.02, c20: float = 0.002) -> Array:
    """Energy that C01 and C20 (relative to C10) add to C10*J1, divided by C10*J1 [-] (section
    3.4.6).

    ERRATUM: the text calls these 3.4 % at lambda = 3 the error of the stiffness; see
    `mooney_rivlin_stiffness_error`.

    >>> round(float(mooney_rivlin_energy_error(3.0)), 3)
    0.034
    """
    return c01 + c20 * strain_invariant(stretch)


def mooney_rivlin_stiffness_error(
    stretch: ArrayLike, c01: float = 0.02, c20: float = 0.002
) -> Array:
    """Gradient in J1 of the energy that C01 and C20 (relative to C10) add, divided by the gradient
    of C10*J1 [-].

    >>> round(float(mooney_rivlin_stiffness_error(3.0)), 3)
    0.048
    """
    return c01 + 2.0 * c20 * strain_invariant(stretch)


def deformed_depth(depth: ArrayLike, bend: ArrayLike) -> Array:
    """Depth d'/h [-] at which rubber from the depth d/h ends up when the actuator bends.

    The differential equation 3.44 keeps the volume; its integral is the cubic
    u**2/2 + bend*u**3/3 = v**2/2 + bend/3 with u = 1 - d'/h and v = 1 - d/h, solved here by Newton
    from u = 1. ERRATUM: the text sets the boundary lambda1 = (1 + kappa*h)/lambda2 with
    lambda2 = 1; at the outer face lambda1 = 1 + kappa*h, lambda2 = 1/lambda1 and lambda3 = 1.
    """
    depth, bend = np.broadcast_arrays(np.asarray(depth, float), np.asarray(bend, float))
    kept = (1.0 - depth) ** 2 / 2.0 + bend / 3.0
    u = np.ones_like(kept)
    for _ in range(SECTION_NEWTON_STEPS):
        u = u - (u**2 / 2.0 + bend * u**3 / 3.0 - kept) / (u + bend * u**2)
    return 1.0 - u


def wall_stretches(depth: ArrayLike, bend: ArrayLike) -> tuple[Array, Array, Array]:
    """Stretches along, across (radial) and around the wall [-] at a depth d/h [-] and a bend
    kappa*h [-] (eq. 3.38-3.40).
    """
    u = 1.0 - deformed_depth(depth, bend)
    along = 1.0 + np.asarray(bend, float) * u
    around = u / (1.0 - np.asarray(depth, float))
    return along, 1.0 / (along * around), around


def wall_strain_invariant(depth: ArrayLike, bend: ArrayLike) -> Array:
    """J1 = sum of the squared stretches - 3 [-] at a depth d/h [-] of the wall and a bend kappa*h
    [-] (Fig. 3.10).

    >>> wall_strain_invariant([0.0, 0.3, 0.5], 2.0).round(3).tolist()
    [7.111, 6.689, 7.386]
    """
    return np.sum(np.square(wall_stretches(depth, bend)), axis=0) - 3.0
