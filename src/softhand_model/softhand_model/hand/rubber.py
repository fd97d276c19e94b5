"""Rubbers: their file, their strain, and which of them is suitable."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from softhand_common.documents.yaml_document import Node, read_document
from softhand_common.numerics.arrays import Array
from softhand_model.data_files import data_file
from softhand_model.hand import plausible

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
