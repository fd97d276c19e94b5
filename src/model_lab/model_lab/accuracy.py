"""How near predictions come: root mean square error and fit in percent."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
IntArray = NDArray[np.int64]


@dataclass(frozen=True)
class Accuracy:
    """Accuracy over some samples, in the unit of the outputs.

    rmse; fit: 100*(1 - |y - yhat|/|y - mean y|) [percent], the mean that of each output, NaN for
    outputs that do not vary; bias: mean of measured minus predicted; largest: of its absolute
    value.
    """

    samples: int
    rmse: float
    fit: float
    bias: float
    largest: float


def accuracy(measured: Array, residual: Array, output: IntArray) -> Accuracy:
    """Accuracy of predictions, given measured values, residuals and outputs (samples,)."""
    spread = float(np.linalg.norm(measured - _means(measured, output)[output]))
    size = float(np.linalg.norm(residual))
    return Accuracy(
        len(residual),
        size / float(np.sqrt(len(residual))),
        100.0 * (1.0 - size / spread) if spread > 0.0 else float("nan"),
        float(residual.mean()),
        float(np.abs(residual).max()),
    )


def _means(values: Array, output: IntArray) -> Array:
    """Mean of each output."""
    return np.asarray(np.bincount(output, values) / np.maximum(np.bincount(output), 1), float)
