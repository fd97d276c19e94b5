"""One casting whose length or height is not what is stated: a typing error, or a cut tip.

A wrong wall looks like another modulus, which `own_moduli` tries. Length and height change the
course of the angle as no modulus does. The factor on such a size is fitted to the runs of this
casting, with the modulus of the others.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from scipy.optimize import minimize_scalar

from model_lab.diagnosis.own_moduli import castings_of, explains, varies_with_castings
from model_lab.diagnosis.result import ADEQUATE, SLIP, Diagnosis
from model_lab.fitting.fit import fit
from model_lab.fitting.problem import base_starts, pose_problem
from model_lab.measurements.measurement_set import MeasurementSet
from model_lab.measurements.preprocess import thinned
from model_lab.rules import RULES
from model_lab.slips.candidates import of_specimens
from model_lab.slips.columns import Candidate
from model_lab.slips.find import SLIP_SAMPLES
from model_lab.slips.mislabelled import errors_of_runs
from model_lab.slips.slip import Slip
from softhand_model.model_file import Model

OWN_SIZE = "size"  # name of the slip
OWN_SIZES = ("length", "height")
SIZE_FACTORS = (0.7, 1.4)  # within which a size is sought


def other_sizes(data: MeasurementSet, found: Diagnosis, model: Model) -> list[Candidate]:
    """The size of one casting of several with which the model predicts all runs best, and other
    sizes that do so nearly as well, the best first; empty unless a diagnosis leaves an error that
    depends on the specimen.
    """
    castings = castings_of(data)
    if data.experiment != "free_bending" or not varies_with_castings(found) or explains(found):
        return []
    few = thinned(data, 1, SLIP_SAMPLES)
    tried = [
        one
        for group in (castings if len(castings) > 1 else ())
        for one in _sizes_of(few, data, [specimen.name for specimen in group], model)
    ]
    tried.sort(key=lambda one: one[0])
    most = RULES.slip_alike**2 * tried[0][0] if tried else 0.0
    return [candidate for error, candidate in tried if error <= most]


def _sizes_of(
    few: MeasurementSet, data: MeasurementSet, names: Sequence[str], model: Model
) -> list[tuple[float, Candidate]]:
    """(sum of squared errors, size) for each size of a casting; few: the set in few samples."""
    others = tuple(run for run in few.runs if run.specimen not in names)
    try:
        problem, given = pose_problem(replace(few, runs=others), model, {})
    except ValueError:  # short runs without repeats show no noise
        return []
    likelihood = problem.likelihood([effect.name for effect in given])
    values = fit(likelihood, base_starts(likelihood.parameters)).values
    scales = [
        value
        for parameter, value in zip(likelihood.parameters, values.tolist(), strict=True)
        if parameter.name.startswith("modulus_scale")
    ]
    calibrated = replace(model, calibration={"modulus_scale": float(np.mean(scales))})
    found = []
    for key in OWN_SIZES:
        if any(np.ndim(data.specimens[name].values.get(key, np.nan)) for name in names):
            continue

        def error(logarithm: float, key: str = key) -> float:
            resized = _resized(few, names, key, float(np.exp(logarithm)))
            return float(errors_of_runs(resized.mended, calibrated).sum())

        best = minimize_scalar(error, bounds=np.log(SIZE_FACTORS), method="bounded")
        if np.isfinite(best.fun):
            found.append((float(best.fun), _resized(data, names, key, float(np.exp(best.x)))))
    return found


def _resized(data: MeasurementSet, names: Sequence[str], key: str, factor: float) -> Candidate:
    stated = {name: float(data.specimens[name].values[key]) for name in names}
    first = 1e3 * next(iter(stated.values()))
    words = f"{first:.4g} mm", f"{factor * first:.4g} mm"
    changes = {name: {key: factor * value} for name, value in stated.items()}
    return of_specimens(data, OWN_SIZE, f"the {key} of {' and '.join(names)}", words, changes)


def with_other_size(
    found: Diagnosis, tried: Sequence[Candidate], resized: Diagnosis
) -> Diagnosis | None:
    """The diagnosis of the set with the first of some sizes, with the slip that says so; None if
    the model then is not adequate. found, resized: diagnoses of the set as stated and with it.
    """
    if (resized.verdict_mended or resized.verdict) != ADEQUATE or not explains(resized):
        return None
    first, *others = tried
    slip = Slip(
        first.name,
        first.column,
        first.said,
        first.fits,
        found.rmse_before,
        resized.rmse_before,
        first.mend,
        alike=tuple(f"{one.column} is {one.fits}, not {one.said}" for one in others),
    )
    slips = (slip, *resized.slips)
    return replace(resized, verdict=SLIP, slips=slips, verdict_mended=ADEQUATE)
