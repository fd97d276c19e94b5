"""Residual tests within a run, which need no repeats: is it white, and does it follow the input?

Scale and zero of each run are removed first: runs scatter in these. The rest is correlated with
itself, and with the input of the run, at lags from 0 on.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from scipy.special import ndtr

from model_lab.aliases import Array
from model_lab.measurements.measurement_set import MeasurementSet
from model_lab.rules import RULES

CORRELATION_LAGS = 20  # samples
SIGN_DRAWS = 4999  # simulated sets in which runs take a sign at random
CORRELATION_LEVEL = 0.95

JSON_DECIMALS = 9  # of correlations, whose last bits depend on where arrays lie in memory


@dataclass(frozen=True)
class WithinRuns:
    """Correlations of the residual within runs, over all runs.

    lag (lags,): lags in samples, from 0. autocorrelation (lags,): that of the residual. white_band:
    half-width of the band in which 95 % of the autocorrelations of white noise lie. white_p_value:
    p-value of the hypothesis that the residual is white, from the autocorrelation at a lag of one
    sample. input_correlation (lags,): correlation of the residual with the input `lag` samples
    earlier. input_band: bound of the largest absolute input_correlation in 95 % of the cases if the
    signs of runs are random. p_value: of the hypothesis that the residual does not follow the
    input. input_band and p_value are None for too few runs.
    """

    lag: Array
    autocorrelation: Array
    white_band: float
    white_p_value: float
    input_correlation: Array
    input_band: float | None
    p_value: float | None

    def as_json(self) -> dict[str, Any]:
        """The dictionary that `--json` writes."""
        return {
            name: None if value is None else np.round(value, JSON_DECIMALS).tolist()
            for name, value in asdict(self).items()
        }

    @property
    def follows_input(self) -> bool:
        """Whether the residual follows the input beyond chance, and by enough to matter."""
        share = float(np.max(self.input_correlation**2))
        sure = self.p_value is not None and self.p_value <= RULES.axis_p_value
        return sure and share >= RULES.input_share


def residual_tests(data: MeasurementSet, residual: Array) -> WithinRuns | None:
    """The tests on a residual (samples,); None for valve pulses, and if no run has enough samples
    and an input that varies.
    """
    found = list(_runs(data, residual))
    if data.experiment == "valve_pulse" or not found:
        return None
    count = sum(len(rest) for rest, _ in found)
    own = np.stack([_products(rest, rest) for rest, _ in found])
    driven = np.stack([_products(rest, course) for rest, course in found])
    size = np.sqrt(own[:, 0].sum() * sum(float(course @ course) for _, course in found)) or 1.0
    autocorrelation = own.sum(axis=0) / (own[:, 0].sum() or 1.0)
    p_value, band = _by_signs(driven / size)
    chance = 2.0 * float(ndtr(-abs(autocorrelation[1]) * np.sqrt(count)))
    return WithinRuns(
        np.arange(CORRELATION_LAGS + 1.0),
        autocorrelation,
        float(1.96 / np.sqrt(count)),
        chance,
        driven.sum(axis=0) / size,
        band,
        p_value,
    )


def _runs(data: MeasurementSet, residual: Array) -> Iterator[tuple[Array, Array]]:
    """Residual without scale and zero, and input about its mean, of each output of each run."""
    table = data.table
    for index, run in enumerate(data.runs):
        measured, left = table.of_run(table.value, index), table.of_run(residual, index)
        course = data.driving(run)
        if run.samples < RULES.notice_samples or not np.ptp(course) > 0.0:
            continue
        for output, rest in zip(measured, left, strict=True):
            predicted = output - rest
            basis = np.linalg.qr(np.stack([np.ones(len(rest)), predicted]).T)[0]
            kept = rest - basis @ (basis.T @ rest)
            if np.all(np.isfinite(kept)):
                about = course - course.mean()
                scale = np.linalg.norm(about) / np.sqrt(len(about))
                yield kept, about / scale


def _products(values: Array, other: Array) -> Array:
    """Sums of products (lags,) of values with another course so many samples before."""
    return np.array(
        [float(values[lag:] @ other[: len(other) - lag]) for lag in range(CORRELATION_LAGS + 1)]
    )


def _by_signs(products: Array) -> tuple[float | None, float | None]:
    """p-value and 95 % band of the largest sum of products (runs, lags) with signs at random."""
    if len(products) < RULES.bootstrap_runs:
        return None, None
    signs = np.random.default_rng(0).choice((-1.0, 1.0), (SIGN_DRAWS, len(products)))
    drawn = np.max(np.abs(signs @ products), axis=1)
    seen = float(np.max(np.abs(products.sum(axis=0))))
    p_value = float((1 + np.sum(drawn >= seen)) / (1 + SIGN_DRAWS))
    return p_value, float(np.quantile(drawn, CORRELATION_LEVEL))
