"""The strips of an imported tensile test: their modulus, which the test itself measures."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from model_lab.importing.runs import ImportedRun
from model_lab.measurements.units import column_unit

EARLY = 0.3  # of the largest elongation, by hand: the modulus is only a start of the fit
MODULUS_DIGITS = 3


def strip_modulus(
    runs: Sequence[ImportedRun], columns: Mapping[str, Mapping[str, object]]
) -> float | None:
    """Shear modulus [Pa] of strips as the first part of all pulls suggests it: the slope of the
    stress over lambda - lambda^-2 (neo-Hookean rubber in tension). None if the stress does
    not rise there.

    columns: entries of the columns in experiment.yaml, with the unit of the stress.
    """
    unit = column_unit("stress", str(columns["stress"]["unit"]))
    stretches, stresses = [], []
    for run in runs:
        stretch = run.columns["stretch"]
        peak = int(np.argmax(stretch)) + 1  # the way back is softer
        early = stretch[:peak] <= 1.0 + EARLY * (stretch[peak - 1] - 1.0)
        stretches.append(stretch[:peak][early])
        stresses.append(unit.to_si(run.columns["stress"][:peak][early]))
    stretch, stress = np.concatenate(stretches), np.concatenate(stresses)
    usable = np.isfinite(stretch) & np.isfinite(stress) & (stretch > 0.0)
    law = stretch[usable] - stretch[usable] ** -2.0
    if len(law) < 2 or not np.ptp(law) > 0.0:
        return None
    slope = float(np.polyfit(law, stress[usable], 1)[0])
    return float(f"{slope:.{MODULUS_DIGITS}g}") if slope > 0.0 else None
