"""The strips of an imported tensile test: their modulus, which the test itself measures."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from model_lab.importing.cell_words import BIAXIAL_MODE, SHEAR_MODE, TENSION_MODE
from model_lab.importing.runs import ImportedRun
from model_lab.measurements.units import column_unit
from softhand_common.documents.quoted import listed

EARLY = 0.3  # of the largest elongation, by hand: the modulus is only a start of the fit
EXPONENTS = {TENSION_MODE: -2.0, SHEAR_MODE: -3.0, BIAXIAL_MODE: -5.0}
MODULUS_DIGITS = 3


def strip_modulus(
    runs: Sequence[ImportedRun],
    columns: Mapping[str, Mapping[str, object]],
    modes: Mapping[str, str] | None = None,
) -> float | None:
    """Shear modulus [Pa] of strips as the first part of all pulls suggests it: the slope of the
    stress over lambda - lambda^-2 (neo-Hookean rubber in tension; in pure shear -3, equibiaxial
    -5). None if the stress does not rise there.

    modes: of each run by its name; None: all in tension. columns: entries of the columns in
    experiment.yaml, with the unit of the stress.
    """
    unit = column_unit("stress", str(columns["stress"]["unit"]))
    laws, stresses = [], []
    for run in runs:
        stretch = run.columns["stretch"]
        peak = int(np.argmax(stretch)) + 1  # the way back is softer
        stress = unit.to_si(run.columns["stress"])
        early = stretch[:peak] <= 1.0 + EARLY * (stretch[peak - 1] - 1.0)
        usable = early & np.isfinite(stress[:peak]) & (stretch[:peak] > 0.0)
        pulled = stretch[:peak][usable]
        laws.append(pulled - pulled ** EXPONENTS[(modes or {}).get(run.name, TENSION_MODE)])
        stresses.append(stress[:peak][usable])
    law, stress = np.concatenate(laws), np.concatenate(stresses)
    if len(law) < 2 or not np.ptp(law) > 0.0:
        return None
    slope = float(np.polyfit(law, stress, 1)[0])
    return float(f"{slope:.{MODULUS_DIGITS}g}") if slope > 0.0 else None


def own_moduli(
    runs: Sequence[ImportedRun],
    specimens: Mapping[str, str],
    columns: Mapping[str, Mapping[str, object]],
    modes: Mapping[str, str],
) -> dict[str, dict[str, object]]:
    """Entries of several strips in experiment.yaml, each with a modulus [Pa] and a batch of its
    own, by their names; empty if there is one strip, or the first part of a pull gives no modulus.
    specimens: name of the strip of each run. columns, modes: as for `strip_modulus`.
    """
    moduli = {
        name: strip_modulus([run for run in runs if specimens[run.name] == name], columns, modes)
        for name in dict.fromkeys(specimens.values())
    }
    if len(moduli) < 2 or None in moduli.values():
        return {}
    return {name: {"shear_modulus": value, "batch": name} for name, value in moduli.items()}


def moduli_words(modulus: float | None, of_strips: Mapping[str, Mapping[str, object]]) -> str:
    """The moduli of strips, in words."""
    each = [f"{entry['shear_modulus']:g} Pa of {name}" for name, entry in of_strips.items()]
    return listed(each) if each else f"{modulus:g} Pa"
