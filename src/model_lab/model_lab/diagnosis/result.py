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
REPEATS_APART = "repeats_apart"  # they differ so much that no number says how sure a verdict is
SLIP = "slip"  # a mistake in how the data are stated; the diagnosis is that of the mended data

LOWERED, MENDED, WITHOUT_EVENTS, THINNED = "lowered", "mended", "events", "thinned"
FLOOR_REASONS = (LOWERED, MENDED, WITHOUT_EVENTS, THINNED)


@dataclass(frozen=True)
class Estimate:
    """A fitted parameter: value, standard error and 95 % interval, in `unit`.

    undetermined: True if the data do not fix it, that is, if the interval covers all possible
    values or the value lies on a bound.
    """

    value: float
    std: float
    interval: tuple[float, float]
    unit: str
    undetermined: bool = False


@dataclass(frozen=True)
class NamedEffect:
    """A missing effect with its fitted parameters by name.

    cause: the class of causes to which the effect belongs, such as "lag"; the name of the effect if
    it has no class. members: maps names of effects of this class that explain the data equally well
    to a word such as "tube", the effect itself first; empty if there are no others.
    cause_confidence: share (0 to 1) of such verdicts in which the class is right; None if this is
    not known. form_of: names of named effects; the data are explained as well if these have another
    equation and this effect is not there (`form_of_others`). kind, where: for an effect of a hand,
    its name without the place, and the place as names by key.
    """

    name: str
    parameters: Mapping[str, Estimate]
    cause: str = ""
    members: Mapping[str, str] = field(default_factory=dict)
    cause_confidence: float | None = None
    form_of: tuple[str, ...] = ()
    kind: str = ""
    where: Mapping[str, str] = field(default_factory=dict)

    @property
    def undetermined(self) -> list[str]:
        """Names of the parameters that the data do not fix."""
        return [name for name, entry in self.parameters.items() if entry.undetermined]

    def as_json(self) -> dict[str, Any]:
        """The entry of this effect in the list `effects` of the JSON of a diagnosis."""
        return {
            "name": self.kind or self.name,
            **({"where": dict(self.where)} if self.where else {}),
            "parameters": {name: asdict(entry) for name, entry in self.parameters.items()},
            "class": self.cause or self.kind or self.name,
            "class_members": list(self.members),
            "class_confidence": self.cause_confidence,
            "form_of": list(self.form_of),
        }


@dataclass(frozen=True)
class Ranked:
    """The model with one more effect.

    rmse_heldout: held-out error with the effect [SI unit of the outputs]. delta_bic: BIC with the
    effect less BIC without it. plausible: whether no parameter lies on a bound. p_value: that noise
    alone would improve the fit as much.
    """

    name: str
    rmse_heldout: float
    delta_bic: float
    plausible: bool
    p_value: float


@dataclass(frozen=True)
class NotVisible:
    """An effect that these data can neither confirm nor exclude, and why."""

    name: str
    reason: str


@dataclass(frozen=True)
class Detectable:
    """The smallest value of an effect's (first) parameter that these data would have shown."""

    name: str
    parameter: str
    smallest: float


@dataclass(frozen=True)
class Failure:
    """Where the model without the missing effects fails: along the axis `against`, in the part
    `where`.

    p_value: of no dependence on the axis. share_of_error: share of the mean square error that
    depends on it.
    """

    against: str
    where: str
    p_value: float
    share_of_error: float


@dataclass(frozen=True)
class Unexplained:
    """The remaining error of the final model.

    rms: its error above the noise floor [SI unit of the outputs]. against: axes on which it
    depends.
    """

    rms: float
    against: tuple[str, ...]


@dataclass(frozen=True)
class Step:
    """How much the held-out error fell when an effect was added. Names of effects that show only
    together are joined by " + ".
    """

    name: str
    rmse_before: float
    rmse_after: float


@dataclass(frozen=True)
class Help:
    """An effect that removes much of the error but leaves much too; rmse_after: held-out error with
    it.
    """

    name: str
    rmse_after: float


@dataclass(frozen=True)
class GreaterPart:
    """The single effect that explains the greater part of an error that no effect explains.

    alike: names of effects of other causes that explain about as much. rmse_after: held-out error
    with it. share: of the mean square error above the noise floor that it removes.
    """

    effect: NamedEffect
    alike: tuple[str, ...]
    rmse_after: float
    share: float


@dataclass(frozen=True)
class Diagnosis:
    """The verdict on a model and a measurement set, in SI units.

    story: the named effects in the order in which they were found. helps: if nothing known explains
    the error, effects that each remove half of the error or more, in order. greater_part: if there
    are none, the effect that removes most of the error above the floor, if one does. notices:
    anomalies of the set that do not depend on the model, see `fitting.notices`. confidence: share
    (0 to 1) of such verdicts that are right; None if this is not known. guess: whether the
    confidence is so low that the verdict counts as a guess. evidence: numbers from which the
    confidence follows, see `diagnosis.confidence`. beyond: names of evidence beyond the range of
    the sets by which the confidence was calibrated, so that the confidence is not known; or
    REPEATS_APART.

    slips: mistakes in how the data are stated. events: what happened in the series of runs, see
    `series.events`. If there are slips or events, the other results are about the corrected data,
    and verdict_mended is the verdict on the corrected data. instead: effects that would explain the
    data as stated as well as the slips do.

    at_bound: parameters of the calibration that lie on a bound in the model without added effects;
    calibration_as_is has their values. freed: calibration and held-out error of that model if the
    modulus is free; None if it lies on no bound. noise_floor_as_is: noise floor estimated with it.
    channel: that of a hand which feeds just the actuators that were named, as stiffer or softer.
    floor_reasons: why `compare` prints another floor than noise_floor, as words of FLOOR_REASONS;
    empty if it prints the same. residual_tests: whether the residual within runs is white, see
    `series.within_runs`. units: units of the columns as stated.
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
    greater_part: GreaterPart | None = None
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
    calibration_as_is: Mapping[str, Any] = field(default_factory=dict)
    freed: Mapping[str, Any] | None = None
    channel: str | None = None
    units: Mapping[str, str] = field(default_factory=dict)
    noise_floor_as_is: float | None = None
    floor_reasons: tuple[str, ...] = ()

    @property
    def display(self) -> Display:
        """Unit and factor with which outputs are shown: in the unit that the user stated
        for them.
        """
        stated = [name for name in OUTPUTS[self.experiment] if name in self.units]
        return stated_display(stated[0], self.units[stated[0]]) if stated else display_of(self.unit)

    def as_json(self) -> dict[str, Any]:
        """The dictionary that `--json` writes."""
        effects = tuple(effect.as_json() for effect in self.effects)
        return {"format": DIAGNOSIS_FORMAT, **asdict(self), "effects": effects}


def named_effect(scored: Scored, effect: str) -> NamedEffect:
    """An effect of a fitted model with the estimates of its parameters."""
    parameters = scored.fit.likelihood.parameters
    return NamedEffect(
        effect,
        {
            parameters[index].name.removeprefix(f"{effect}."): estimate(scored, index)
            for index in scored.parameters_of(effect)
        },
    )


def estimate(scored: Scored, index: int) -> Estimate:
    """The estimate of one parameter (by its index) of a fitted model. The interval is wider for few
    runs. It allows for errors of the predictions themselves, and for an error in the form of the
    equation (`Rules.form_error`).
    """
    fitted, scales = scored.fit, scored.fit.likelihood.scales
    parameter = fitted.likelihood.parameters[index]
    covariance = fitted.covariance + fitted.own_covariance
    spread = float(np.sqrt(max(covariance[index, index], 0.0)))
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
    """The fitted calibration in the form in which a model file holds it."""
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
    """Fitted shear modulus [Pa] of each batch, where the modulus itself is what is measured; else
    None. If specimens of a batch state different moduli, that of the first one is scaled.
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
    """Correlation matrix (k, k) of the k parameters of a fitted model."""
    std = np.sqrt(np.maximum(np.diag(scored.fit.covariance), 0.0))
    size = np.where(std > 0.0, std, 1.0)
    return np.asarray(scored.fit.covariance / np.outer(size, size))


def correlation_of(scored: Scored) -> dict[str, dict[str, float]]:
    """Correlation of every two parameters of a fitted model, as a dictionary by both names."""
    names, rows = scored.fit.likelihood.names, correlation(scored).tolist()
    return {name: dict(zip(names, row, strict=True)) for name, row in zip(names, rows, strict=True)}
