"""Fibres of the hull and of the passive layer: expansion of the hull, and largest stress with a
thread in the rubber (sections 3.3.1 and 3.3.2).
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from softhand_common.documents.yaml_document import Bounds, Node, read_document
from softhand_model.hand.plausible import YOUNGS_MODULUS

FIBRES_FILE = Path(__file__).parent / "data" / "fibres.yaml"
FORMAT = "softhand-fibres/1"
FIBRE_SHARE = Bounds(0.0, 1.0, "")
WIDTH = Bounds(1e-7, 0.01, "m")  # from a tenth of a micrometre on: in um or mm it is outside


@dataclass(frozen=True)
class Thread:
    """A thread that is wound around the actuator or laid into it: its fibre and its width [m]."""

    name: str
    fibre: str
    width: float


@dataclass(frozen=True)
class Fibres:
    """Young's moduli [Pa] of fibres by name, threads by name, and the share [-] of fibre in the
    hull's volume.
    """

    moduli: dict[str, float]
    threads: dict[str, Thread]
    share: float


def load_fibres(path: Path | None = None) -> Fibres:
    """The fibres of data/fibres.yaml or another file of its format.

    Raises ValueError naming file, key, expected and got.

    >>> load_fibres().threads["thread 50/2"].width
    0.0005
    """
    document = read_document(path or FIBRES_FILE, FORMAT)
    fields = document.fields(["format", "share", "fibres", "threads"])
    moduli = {
        name: node.fields(["modulus"])["modulus"].within(YOUNGS_MODULUS)
        for name, node in fields["fibres"].mapping().items()
    }
    threads = {
        name: _thread(name, node, moduli) for name, node in fields["threads"].mapping().items()
    }
    return Fibres(moduli, threads, fields["share"].within(FIBRE_SHARE))


def _thread(name: str, node: Node, moduli: dict[str, float]) -> Thread:
    fields = node.fields(["fibre", "width"])
    return Thread(name, fields["fibre"].choice(list(moduli)), fields["width"].within(WIDTH))


def radial_modulus(rubber: float, fibre: float, share: float = 0.02) -> float:
    """Young's modulus [Pa] across the helix: volume mean of rubber and fibre (eq. 3.3)."""
    return (1.0 - share) * rubber + share * fibre


def radial_stretch(axial_stretch: float, axial_modulus: float, radial_modulus: float) -> float:
    """Stretch [-] across the fibres at an axial one, moduli [Pa] (eq. 3.1 and 3.2).

    ERRATUM: for stiff silicone Table 3.1 prints 2.70; its own numbers give 2.69.

    >>> round(radial_stretch(3.0, 0.15e6, radial_modulus(0.15e6, 2.5e9)), 3)
    1.006
    """
    return 1.0 + (axial_stretch - 1.0) * axial_modulus / radial_modulus


def thinner(modulus: float, than: float) -> float:
    """Ratio [-] of the diameters of two fibres that are equally stiff in tension: the one with
    Young's modulus `modulus` over the one with `than`, both [Pa].

    ERRATUM: section 3.3.1 calls a fibre of HD-PE 40 times thinner than one of PET; 46, the ratio of
    the moduli, is the ratio of the cross sections, while that of the diameters is 6.8.

    >>> round(1.0 / thinner(115e9, 2.5e9), 1)
    6.8
    """
    return float(np.sqrt(than / modulus))


def griffith_stress(modulus: float, surface_energy: float, width: float) -> float:
    """Largest stress [Pa] of a solid with a crack of the full width a [m] (eq. 3.4).

    sqrt(4*E*G_c/(pi*a)) with Young's modulus E [Pa] and the surface energy G_c [J/m2], which the
    thesis does not give. A fibre in the rubber counts as such a crack: mesh threads of 70 um allow
    2.7 times the stress of a 0.5 mm thread.

    >>> round(griffith_stress(0.15e6, 10.0, 70e-6) / griffith_stress(0.15e6, 10.0, 0.5e-3), 2)
    2.67
    """
    return float(np.sqrt(4.0 * modulus * surface_energy / (np.pi * width)))
