"""Result of a diagnosis: the JSON of the contract as data classes, and fitted parameters."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from typing import Any

import numpy as np
from scipy.special import stdtrit

from model_lab.aliases import Array
from model_lab.diagnosis.search import Scored
from model_lab.measurements.measurement_set import OUTPUTS, MeasurementSet
from model_lab.measurements.units import Display, display_of, stated_display
from model_lab.rules import RULES
from model_lab.slips.slip import Slip

DIAGNOSIS_FORMAT = "softhand-diagnosis/1"
ADEQUATE, EFFECTS_MISSING, UNEXPLAINED = "adequate", "effects_missing", "unexplained"
SLIP = "slip"  # a mistake in how the data are stated; the diagnosis is that of the mended data

LOWERED, MENDED, WITHOUT_EVENTS, THINNED = "lowered", "mended", "events", "thinned"
FLOOR_REASONS = (LOWERED, MENDED, WITHOUT_EVENTS, THINNED)


@dataclass(frozen=True)
class Estimate:
    """A fitted parameter: value, standard error and 95 % interval in its unit.

    undetermined: the data do not fix it: the interval reaches over all possible values, or the
    value lies at their end.
    """

    value: float
    std: float
    interval: tuple[float, float]
    unit: str
    undetermined: bool = False


@dataclass(frozen=True)
class NamedEffect:
    """A missing effect with its fitted parameters by name.

    cause: the class of causes it belongs to, such as "lag"; its own name without one. members: of
    that class those that explain the data alike, by name of effect, in words such as "tube", the
    effect itself first; empty where it stands alone. cause_confidence: share (0 to 1) of such
    verdicts in which the class is right, None where that is not known. kind, where: of an effect
    of a hand, what it is called without its place, and the place, names by key.
    """

    name: str
    parameters: Mapping[str, Estimate]
    cause: str = ""
    members: Mapping[str, str] = field(default_factory=dict)
    cause_confidence: float | None = None
    kind: str = ""
    where: Mapping[str, str] = field(default_factory=dict)

    @property
    def undetermined(self) -> list[str]:
        """Names of the parameters that the data do not fix."""
        return [name for name, entry in self.parameters.items() if entry.undetermined]

    def as_json(self) -> dict[str, Any]:
        """The entry of `effects` in the JSON of a diagnosis."""
        return {
            "name": self.kind or self.name,
            **({"where": dict(self.where)} if self.where else {}),
            "parameters": {name: asdict(entry) for name, entry in self.parameters.items()},
            "class": self.cause or self.kind or self.name,
            "class_members": list(self.members),
            "class_confidence": self.cause_confidence,
        }


@dataclass(frozen=True)
class Ranked:
    """One effect alone: held-out error with it, BIC against the model without, and its p-value.

    plausible: its parameters lie off their bounds.
    """

    name: str
    rmse_heldout: float
    delta_bic: float
    plausible: bool
    p_value: float


@dataclass(frozen=True)
class NotVisible:
    """An effect about which these data say nothing."""

    name: str
    reason: str


@dataclass(frozen=True)
class Detectable:
    """The smallest value of an effect's parameter that would have shown."""

    name: str
    parameter: str
    smallest: float


@dataclass(frozen=True)
class Failure:
    """Where the model without the missing effects fails."""

    against: str
    where: str
    p_value: float
    share_of_error: float


@dataclass(frozen=True)
class Unexplained:
    """What the final model leaves above the noise floor, and on what it depends."""

    rms: float
    against: tuple[str, ...]


@dataclass(frozen=True)
class Step:
    """How the held-out error fell when an effect was added; several that show only together are
    joined by " + ".
    """

    name: str
    rmse_before: float
    rmse_after: float


@dataclass(frozen=True)
class Help:
    """An effect that takes much of the error and leaves much: held-out error with it."""

    name: str
    rmse_after: float


@dataclass(frozen=True)
class Diagnosis:
    """The verdict on a model and a measurement set, in SI units.

    story: the named effects as they were found. helps: where nothing known explains the error,
    effects that each take half of it or more, in order. notices: anomalies of the set whatever
    the model, see `fitting.notices`. confidence: share of such verdicts that are right, 0 to 1,
    None if it is not known; guess: whether that is too little to stand by it; evidence: what it
    follows from, see `diagnosis.confidence`; beyond: of this what lies beyond all that was seen
    when the confidence was calibrated, which is why it is not known. slips: mistakes in how the
    data are stated, told before all else; events: what happened in the series of runs, see
    `series.events`. With either, all else is about the data without them, and verdict_mended is the
    verdict on these. instead: effects that would explain the data as stated as well as the slips
    do. at_bound: parameters of the calibration that lie on a bound in the model as it is.
    noise_floor_as_is: the floor of the model as it is; floor_reasons: why `compare` prints another
    than noise_floor, of FLOOR_REASONS, empty where it prints the same.
    residual_tests: whether the residual within runs is white, see `series.within_runs`. units: of
    the columns as they were stated.
    """

    experiment: str
    verdict: str
    holdout: str
    effects: tuple[NamedEffect, ...]
    tied: tuple[tuple[str, ...], ...]
    ranking: tuple[Ranked, ...]
    not_visible: tuple[NotVisible, ...]
    detectable: tuple[Detectable, ...]
    calibration: Mapping[str, Any]
    noise_floor: float
    noise_floor_parts: Mapping[str, float]
    noise_floor_source: str
    rmse_before: float
    rmse_after: float
    unit: str
    failures: tuple[Failure, ...]
    unexplained: Unexplained
    next_experiment: Mapping[str, Any] | None = None
    correlation: Mapping[str, Mapping[str, float]] | None = None
    story: tuple[Step, ...] = ()
    helps: tuple[Help, ...] = ()
    notices: tuple[Mapping[str, Any], ...] = ()
    modulus: Mapping[str, Estimate] | None = None
    confidence: float | None = None
    guess: bool = False
    evidence: Mapping[str, float] | None = None
    beyond: tuple[str, ...] = ()
    slips: tuple[Slip, ...] = ()
    verdict_mended: str | None = None
    events: tuple[Mapping[str, Any], ...] = ()
    residual_tests: Mapping[str, Any] | None = None
    instead: tuple[str, ...] = ()
    at_bound: tuple[str, ...] = ()
    units: Mapping[str, str] = field(default_factory=dict)
    noise_floor_as_is: float | None = None
    floor_reasons: tuple[str, ...] = ()

    @property
    def display(self) -> Display:
        """How outputs are shown: in the unit that the user stated for them."""
        stated = [name for name in OUTPUTS[self.experiment] if name in self.units]
        return stated_display(stated[0], self.units[stated[0]]) if stated else display_of(self.unit)

    def as_json(self) -> dict[str, Any]:
        """The dictionary that `--json` writes."""
        effects = tuple(effect.as_json() for effect in self.effects)
        return {"format": DIAGNOSIS_FORMAT, **asdict(self), "effects": effects}


def named_effect(scored: Scored, effect: str) -> NamedEffect:
    """An effect of a fitted model with its parameters, errors and 95 % intervals."""
    parameters = scored.fit.likelihood.parameters
    return NamedEffect(
        effect,
        {
            parameters[index].name.removeprefix(f"{effect}."): estimate(scored, index)
            for index in scored.parameters_of(effect)
        },
    )


def estimate(scored: Scored, index: int) -> Estimate:
    """One parameter of a fitted model; the interval allows for the few runs there are, and for what
    the form of the equation leaves out.
    """
    fitted, scales = scored.fit, scored.fit.likelihood.scales
    parameter = fitted.likelihood.parameters[index]
    spread = float(np.sqrt(max(fitted.covariance[index, index], 0.0)))
    runs = fitted.likelihood.spectrum.table.runs
    factor = float(stdtrit(max(runs - len(fitted.values), 3), RULES.interval_level))
    center = scales.inward(fitted.values)
    size = 1.0 if scales.logarithmic[index] else abs(float(fitted.values[index]))
    reach = factor * float(np.hypot(spread, RULES.form_error * size))
    ends = []
    for side in (-1.0, 1.0):
        moved = center.copy()
        moved[index] += side * reach
        ends.append(float(scales.outward(np.clip(moved, scales.low, scales.high))[index]))
    value = float(fitted.values[index])
    std = value * spread if scales.logarithmic[index] else spread
    unbounded = center[index] - reach <= scales.low[index]
    unbounded = unbounded and center[index] + reach >= scales.high[index]
    undetermined = bool(unbounded or fitted.at_limit[index])
    return Estimate(value, std, (ends[0], ends[1]), parameter.unit, undetermined)


def calibration_of(scored: Scored) -> dict[str, Any]:
    """The fitted calibration as a model file holds it."""
    found: dict[str, Any] = {}
    parameters = scored.fit.likelihood.parameters
    for parameter, value in zip(parameters, scored.fit.values.tolist(), strict=True):
        if parameter.effect is None:
            name, _, entry = parameter.name.partition("[")
            if entry:
                found.setdefault(name, {})[entry.rstrip("]")] = value
            else:
                found[name] = value
    return found


def calibration_at_bound(scored: Scored) -> tuple[str, ...]:
    """Names of the parameters of the calibration that lie on a bound."""
    pairs = zip(scored.fit.likelihood.parameters, scored.fit.at_limit, strict=True)
    return tuple(p.name for p, limit in pairs if p.effect is None and limit)


def modulus_of(scored: Scored, data: MeasurementSet) -> dict[str, Estimate] | None:
    """Fitted shear modulus [Pa] of each batch, where that is what is measured; of the first
    specimen, if those of a batch differ.
    """
    if not data.free_modulus:
        return None
    stated = {
        specimen.batch: specimen.values["shear_modulus"]
        for run in reversed(data.runs)
        for specimen in [data.specimens[run.specimen]]
    }
    found = {}
    for index, parameter in enumerate(scored.fit.likelihood.parameters):
        batch = parameter.name.removeprefix("modulus_scale[").rstrip("]")
        if parameter.name.startswith("modulus_scale[") and batch in stated:
            scale, nominal = estimate(scored, index), float(stated[batch])
            ends = (nominal * scale.interval[0], nominal * scale.interval[1])
            found[batch] = Estimate(nominal * scale.value, nominal * scale.std, ends, "Pa")
    return found


def correlation(scored: Scored) -> Array:
    """Correlation (k, k) of the parameters of a fitted model."""
    std = np.sqrt(np.maximum(np.diag(scored.fit.covariance), 0.0))
    size = np.where(std > 0.0, std, 1.0)
    return np.asarray(scored.fit.covariance / np.outer(size, size))


def correlation_of(scored: Scored) -> dict[str, dict[str, float]]:
    """Correlation of every two parameters of a fitted model, by their names."""
    names, rows = scored.fit.likelihood.names, correlation(scored).tolist()
    return {name: dict(zip(names, row, strict=True)) for name, row in zip(names, rows, strict=True)}
