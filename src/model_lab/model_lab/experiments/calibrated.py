"""Calibration of the rubber: one factor on the shear modulus for each batch."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from model_lab.measurement import MeasurementSet

Array = NDArray[np.float64]


def batches(data: MeasurementSet) -> list[str]:
    """Batches of the specimens of a set's runs, in their order."""
    return list(dict.fromkeys(data.specimens[run.specimen].batch for run in data.runs))


def modulus_scales(data: MeasurementSet) -> dict[str, float]:
    """Names of the factors, with the value from which a search starts."""
    return {f"modulus_scale[{batch}]": 1.0 for batch in batches(data)}


def modulus_of_runs(data: MeasurementSet, calibration: Mapping[str, Array]) -> Array:
    """Factor (lanes, runs, 1) on the shear modulus of each run, from values (lanes,) by name."""
    of_runs = [f"modulus_scale[{data.specimens[run.specimen].batch}]" for run in data.runs]
    scales = [np.atleast_1d(calibration.get(name, 1.0)) for name in of_runs]
    return np.stack(np.broadcast_arrays(*scales), axis=1)[:, :, None]
