"""What speaks for or against a fitted model besides its error: the usual ranges of parameters,
gauges at rest, times that the samples cannot tell.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from model_lab.aliases import Array
from model_lab.fitting.fit import Fit
from model_lab.measurements.measurement_set import MeasurementSet
from softhand_model.effects import Effect

UNRESOLVED = 0.5  # of the time between samples, beside another parameter
NOTHING = 0.1  # the same of a time alone, beside other effects
GAUGE_ZERO = "pressure_offset.offset"
FARTHEST_ZERO = 2.0  # times a zero, beyond which a first reading is no open chamber's
AGREES = 0.05  # of the readings at rest, to which they tell the gauge's zero


def unusual(fit: Fit) -> float:
    """Deviance by which effects' parameters outside of their usual ranges are unlikely beforehand:
    even within a range, and with normal tails beyond, whose sigma is half of it.
    """
    scales = fit.likelihood.scales
    ends = np.array([p.typical for p in fit.likelihood.parameters], float).reshape(-1, 2)
    low, high = scales.inward(ends.T)
    at = scales.inward(fit.values)
    beyond = np.maximum(np.maximum(low - at, at - high), 0.0) / (0.5 * scales.width)
    of_effects = [bool(p.effect) for p in fit.likelihood.parameters]
    return float(np.sum(beyond[of_effects] ** 2))


def seen_at_rest(data: MeasurementSet, fit: Fit) -> float:
    """Deviance by which the first readings of runs, made at rest and without pressure, are more
    likely with a fitted zero of the gauge than with none.

    A dead zone, or a zero of the output, draws the same curve and lets the gauge read nothing.
    """
    names = fit.likelihood.names
    zero = fit.values[names.index(GAUGE_ZERO)] if GAUGE_ZERO in names else 0.0
    first = read_at_rest(data, zero)
    if not np.any(first):
        return 0.0
    least = AGREES**2 * np.mean(np.square(first))
    about = np.mean(np.square(first - zero)) + least
    return float(max(len(first) * np.log((np.mean(np.square(first)) + least) / about), 0.0))


def read_at_rest(data: MeasurementSet, zero: float) -> Array:
    """First readings [Pa] of runs that began with an open chamber, for all that a gauge whose zero
    reads so much [Pa] can tell.
    """
    first = np.array(
        [r.columns["pressure"][0] for r in data.runs if "pressure" in r.columns and not r.steady]
    )
    return first[np.abs(first) <= FARTHEST_ZERO * abs(zero)]


def is_resolved(data: MeasurementSet, fit: Fit, effect: type[Effect], beside: bool = False) -> bool:
    """Whether the samples are near enough to each other to tell the times of an effect, unless its
    memory goes on beyond them.

    Below their distance a product with another parameter is told and no time. Far below it what the
    input did between samples looks like a lag, beside other effects.
    """
    times = [p.name for p in effect.parameters if p.unit == "s" and p.neutral is None]
    alone = len(effect.parameters) < 2
    if not times or effect.endless or not data.has_time or (alone and not beside):
        return True
    least = NOTHING if alone else UNRESOLVED
    return min(_steps(data, fit, effect, times)) >= least


def is_between_samples(data: MeasurementSet, fit: Fit, effect: type[Effect]) -> bool:
    """Whether an effect lasts for less than the time between samples: how well it does then hangs
    on what the input did between them, which nobody has seen.
    """
    times = [p.name for p in effect.parameters if p.unit == "s"]
    if not times or effect.endless or not data.has_time:
        return False
    return min(_steps(data, fit, effect, times)) < 1.0


def _steps(
    data: MeasurementSet, fit: Fit, effect: type[Effect], times: Sequence[str]
) -> list[float]:
    """Times of an effect over the usual time between samples [-]."""
    apart = [float(np.median(np.diff(run.columns["time"]))) for run in data.runs if run.samples > 1]
    values = dict(zip(fit.likelihood.names, fit.values.tolist(), strict=True))
    step = float(np.median(apart)) if apart else 0.0
    found = [abs(values[f"{effect.name}.{name}"]) for name in times]
    return [time / step if step > 0.0 else np.inf for time in found]
