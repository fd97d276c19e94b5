"""Specimens of one batch that differ, as castings do: each is given a shear modulus of its own.

A wall that is 0.2 mm thicker than drawn, or air in the mix, makes one finger of a batch a few per
cent softer or stiffer than another. The calibration has one modulus for a batch, so no effect
explains that.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from model_lab.diagnosis.result import SLIP, UNEXPLAINED, Diagnosis
from model_lab.experiments.samples import USUAL_MODULUS_SCALES
from model_lab.measurements.measurement_set import UNSTATED_BATCH, MeasurementSet, Specimen
from model_lab.rules import RULES
from model_lab.slips.columns import one_line
from model_lab.slips.slip import Slip

OWN_MODULI = "batch"  # name of the slip
CASTINGS = "castings"  # kind of the notice
OF_SPECIMENS = {"specimen", "wall"}  # axes along which castings differ


def may_differ(data: MeasurementSet, found: Diagnosis) -> dict[str, str]:
    """The batch of each specimen that has runs, if each casting should have a batch of its own.

    Empty unless the error that a diagnosis leaves is more than noise and depends on the specimen.
    Specimens that differ only in how they are mounted count as one casting, with one batch.
    """
    if not varies_with_castings(found) or explains(found):
        return {}
    castings = castings_of(data)
    batches = {one.batch for group in castings for one in group}
    if len(castings) <= len(batches):
        return {}
    return {one.name: group[0].name for group in castings for one in group}


def castings_of(data: MeasurementSet) -> list[list[Specimen]]:
    """The specimens that have runs, those together that are one casting in several mounts."""
    castings: list[list[Specimen]] = []
    for name in dict.fromkeys(run.specimen for run in data.runs):
        one = data.specimens[name]
        mounted = (others for others in castings if _is_mounted_anew(one, others))
        same = next(mounted, None)
        if same is None:
            castings.append([one])
        else:
            same.append(one)
    return castings


def varies_with_castings(found: Diagnosis) -> bool:
    """Whether the error of a model whose modulus is calibrated depends on the specimen."""
    failing = {failure.against for failure in found.failures if _unexplained(found)}
    axes = {*found.unexplained.against, *failing}
    return "modulus_scale" in found.calibration and bool(axes & OF_SPECIMENS)


def with_batches(data: MeasurementSet, batches: Mapping[str, str]) -> MeasurementSet:
    """The set with other batches of its specimens, by name."""
    changed = {name: replace(data.specimens[name], batch=own) for name, own in batches.items()}
    return replace(data, specimens={**data.specimens, **changed})


def with_own_moduli(
    data: MeasurementSet, found: Diagnosis, batches: Mapping[str, str], parted: Diagnosis
) -> Diagnosis | None:
    """The diagnosis of the set with own moduli, with the slip that says so, or a mere notice where
    no batch was stated and they hardly differ (`Rules.casting_spread`); None if they do not explain
    the set within the usual range. found, parted: diagnoses of the set as stated and of
    `with_batches`.
    """
    scales = parted.calibration["modulus_scale"]
    at_bound = np.isclose([[scales[batch]] for batch in batches.values()], USUAL_MODULUS_SCALES)
    if not explains(parted) or (at_bound.any() and not data.free_modulus):
        return None
    own = ", ".join(f"{batch} {scales[batch]:.3g}" for batch in dict.fromkeys(batches.values()))
    mend = one_line({"specimens": {name: {"batch": batch} for name, batch in batches.items()}})
    spread = max(scales.values()) / min(scales.values()) - 1.0
    stated = any(data.specimens[name].batch != UNSTATED_BATCH for name in batches)
    if spread <= RULES.casting_spread and not stated:
        text = f"castings differ, as usual: their moduli are {own} times the stated one ({mend})"
        notice = {"kind": CASTINGS, "value": spread, "size": 0.0, "text": text}
        return replace(parted, notices=(notice, *parted.notices))
    slip = Slip(
        OWN_MODULI,
        "shear_modulus",
        "one for the batch",
        f"{own} times the stated one",
        found.rmse_before,
        parted.rmse_before,
        mend,
    )
    slips, mended = (slip, *parted.slips), parted.verdict_mended or parted.verdict
    return replace(parted, verdict=SLIP, slips=slips, verdict_mended=mended)


def _unexplained(found: Diagnosis) -> bool:
    return (found.verdict_mended or found.verdict) == UNEXPLAINED


def explains(found: Diagnosis) -> bool:
    """Whether the error that is left is about the noise floor."""
    return not _unexplained(found) and (
        found.rmse_after <= RULES.explained_error * found.noise_floor
    )


def _is_mounted_anew(one: Specimen, others: list[Specimen]) -> bool:
    """Whether a specimen has the sizes of others, which are all mounted in another way."""
    return all(one.mount != other.mount and _same(one.values, other.values) for other in others)


def _same(one: Mapping[str, Any], other: Mapping[str, Any]) -> bool:
    return one.keys() == other.keys() and all(np.array_equal(one[k], other[k]) for k in one)
