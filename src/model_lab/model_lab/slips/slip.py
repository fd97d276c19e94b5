"""A slip: a mistake in how data are stated, such as a wrong unit, without which the data fit the
model.
"""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Slip:
    """A slip that was found.

    name: its kind, such as `unit`, `absolute`, `sign` or `odd_run`. column: the column, the key of
    the specimens, or the run that it is about. said, fits: what the set states, and what fits
    instead, such as `kPa` and `psi`. rmse_before, rmse_after: held-out error of the model on the
    data as stated and as corrected, with the calibration fitted to each, in the SI unit of the
    outputs (which the correction may change). mend: text to paste into experiment.yaml in place of
    the present one.
    beside: effect that the model needs, in addition to the correction, to reach rmse_after; "" if
    none. alike: other slips that explain the data about as well, such as `pressure is inHg, not
    kPa`. factor: of a slip that is a mere factor, such as a unit: the factor by which the corrected
    data still differ from the model beyond chance, so that it may be none; else 1. modulus: factor
    on the stated shear modulus with which the data as stated fit as well; 1 if there is none that
    another mix of the rubber may have.
    """

    name: str
    column: str
    said: str
    fits: str
    rmse_before: float
    rmse_after: float
    mend: str
    beside: str = ""
    alike: tuple[str, ...] = ()
    factor: float = 1.0
    modulus: float = 1.0
