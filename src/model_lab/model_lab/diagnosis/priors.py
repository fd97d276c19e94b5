"""Priors of a fitted model: what makes it likely or unlikely apart from its error, such as the
usual ranges of parameters, readings at rest, and time constants shorter than the time between
samples.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from model_lab.aliases import Array
from model_lab.fitting.fit import Fit
from model_lab.measurements.measurement_set import MeasurementSet
from model_lab.rules import RULES, Rules
from softhand_model.effects import Effect

GAUGE_ZERO = "pressure_offset.offset"
EMPIRICAL = frozenset(
    {
        "actuation_nonlinearity",
        "ballooning",
        "chamber_contact",
        "passive_layer_slack",
        "section_rounding",
        "thick_wall",
    }
)
"""Effects that say how much an actuator moves, not why: of a geometry that was measured."""


def unusual(fit: Fit) -> float:
    """Deviance added for effect parameters outside their usual ranges. Within a range the prior is
    flat; beyond it falls off like a normal distribution whose standard deviation is half the range.
    """
    scales = fit.likelihood.scales
    ends = np.array([p.typical for p in fit.likelihood.parameters], float).reshape(-1, 2)
    low, high = scales.inward(ends.T)
    at = scales.inward(fit.values)
    beyond = np.maximum(np.maximum(low - at, at - high), 0.0) / (0.5 * scales.width)
    of_effects = [bool(p.effect) for p in fit.likelihood.parameters]
    return float(np.sum(beyond[of_effects] ** 2))


def seen_at_rest(data: MeasurementSet, fit: Fit, rules: Rules = RULES) -> float:
    """Deviance by which the first readings of runs, at rest and without pressure, are more likely
    with the fitted zero of the pressure sensor than with a zero of 0.

    A dead zone and a wrong zero of the output give the same curve, but with them the sensor reads 0
    at rest.
    """
    names = fit.likelihood.names
    zero = fit.values[names.index(GAUGE_ZERO)] if GAUGE_ZERO in names else 0.0
    first = read_at_rest(data, zero, rules)
    if not np.any(first):
        return 0.0
    least = rules.zero_agreement**2 * np.mean(np.square(first))
    about = np.mean(np.square(first - zero)) + least
    return float(max(len(first) * np.log((np.mean(np.square(first)) + least) / about), 0.0))


def read_at_rest(data: MeasurementSet, zero: float, rules: Rules = RULES) -> Array:
    """First pressure readings [Pa] of runs that may have begun with an open chamber, if `zero` [Pa]
    is what the sensor reads at zero pressure.
    """
    first = np.array(
        [r.columns["pressure"][0] for r in data.runs if "pressure" in r.columns and not r.steady]
    )
    return first[np.abs(first) <= rules.open_chamber_range * abs(zero)]


def is_resolved(
    data: MeasurementSet,
    fit: Fit,
    effect: type[Effect],
    beside: bool = False,
    rules: Rules = RULES,
) -> bool:
    """Whether the samples are close enough in time to fit the time constants of an effect; True for
    effects whose memory never fades.

    Below the time between samples only the product of a time constant and another parameter can be
    fitted. Far below it, the unknown input between samples looks like a lag. beside: whether the
    model has other effects too.
    """
    times = [p.name for p in effect.parameters if p.unit == "s" and p.neutral is None]
    alone = len(effect.parameters) < 2
    if not times or effect.endless or not data.has_time or (alone and not beside):
        return True
    least = rules.resolved_time_alone if alone else rules.resolved_time
    return min(_steps(data, fit, effect, times)) >= least


def is_between_samples(data: MeasurementSet, fit: Fit, effect: type[Effect]) -> bool:
    """Whether an effect lasts for less than the time between samples. How well it fits then depends
    on the input between samples, which was not recorded.
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
