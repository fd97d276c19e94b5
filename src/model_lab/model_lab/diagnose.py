"""Diagnosis of a model against a measurement set: what is missing, as far as the data can tell."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.stats import t as student

from model_lab.candidates import inapplicable
from model_lab.diagnosis import (
    ADEQUATE,
    EFFECTS_MISSING,
    UNEXPLAINED,
    Detectable,
    Diagnosis,
    Estimate,
    NamedEffect,
    NotVisible,
    Ranked,
    Unexplained,
)
from model_lab.fit import Problem, fit
from model_lab.forward import Forward
from model_lab.loading import load_measurements
from model_lab.measurement import MeasurementSet
from model_lab.noise import noise_floor
from model_lab.rivals import Rival, fit_rivals
from model_lab.search import Question, Scored
from model_lab.selection import Selection, excess, material, select
from model_lab.series import series_of
from model_lab.spectrum import make_spectrum
from softhand_model.effects import Effect, effect_classes
from softhand_model.model_file import Model, load_model

Array = NDArray[np.float64]

NEAR_FLOOR = 1.3  # held-out error over the floor that counts as explained
LEFT_OVER = 0.3  # share of the excess error that an effect of another form may leave
RIVAL_MARGIN = 0.85  # held-out error of a black box over the model's, below which it knows more
CONFIDENCE = 0.975
SMALLEST_SHOWN = 0.5  # rms of an effect over the floor that makes an error material


@dataclass(frozen=True)
class Outcome:
    """A diagnosis with what it was drawn from, for reports."""

    diagnosis: Diagnosis
    question: Question
    selection: Selection
    rivals: tuple[Rival, ...]


def diagnose(
    data: MeasurementSet,
    model: Model,
    classes: Mapping[str, type[Effect]] | None = None,
    seed: int = 0,
    jobs: int = 1,
) -> Outcome:
    """Compare a model with a set, search the effects for what is missing, and judge the rest.

    classes: effects that take part, the built-in ones if None. Effects of the model file that carry
    standard errors are fitted along, the others stay as they are. Same seed, same answer.
    Raises ValueError for data that the model cannot use.
    """
    question, given = pose_question(data, model, effect_classes() if classes is None else classes)
    present = {effect.name for effect in model.effects}
    hidden, tried = [], []
    for name, effect in question.classes.items():
        if name in present:
            continue
        reason = inapplicable(effect, data, model.base)
        if reason is None:
            tried.append(name)
        else:
            hidden.append(NotVisible(name, reason))
    selection = select(question, tried, [effect.name for effect in given], seed, jobs)
    return _outcome(question, selection, hidden)


def diagnose_folder(
    folder: str | Path, model: str | Path = "base", seed: int = 0, jobs: int = 1
) -> dict[str, Any]:
    """The diagnosis of a measurement set on disk, as the dictionary that `--json` writes."""
    outcome = diagnose(load_measurements(folder), load_model(model), seed=seed, jobs=jobs)
    return outcome.diagnosis.as_json()


def pose_question(
    data: MeasurementSet, model: Model, classes: Mapping[str, type[Effect]]
) -> tuple[Question, tuple[Effect, ...]]:
    """The question with its noise floor, and the model's effects that are fitted along.

    The floor is seen from the residual of the model as it is, with its calibration fitted.
    """
    given = tuple(effect for effect in model.effects if effect.name in model.std)
    fixed = tuple(effect for effect in model.effects if effect.name not in model.std)
    known = {**classes, **{effect.name: type(effect) for effect in given}}
    forward = Forward(data, model.base, [type(effect) for effect in given], fixed)
    start = forward.start()[None]
    layout = series_of(data)
    spectrum = make_spectrum(layout, forward.predict(start)[0])
    rough = noise_floor(data, spectrum, forward.measured - forward.predict(start)[0])
    better = fit(Problem(forward, spectrum, rough.variance), start)
    spectrum = make_spectrum(layout, forward.measured - better.residual)
    floor = noise_floor(data, spectrum, better.residual)
    return Question(data, model.base, fixed, known, spectrum, floor), given


def _outcome(question: Question, selection: Selection, hidden: list[NotVisible]) -> Outcome:
    base, final = selection.base, selection.final
    predicted = base.fit.problem.forward.measured - base.fit.residual
    rivals = tuple(fit_rivals(final.fit, question.data, predicted))
    verdict = _verdict(question, selection, rivals)
    named = final if verdict == EFFECTS_MISSING else base
    added = [name for name in named.effects if name not in base.effects]
    floor = question.floor
    rest = excess(question, final)
    diagnosis = Diagnosis(
        experiment=question.data.experiment,
        verdict=verdict,
        holdout=question.spectrum.layout.holdout,
        effects=tuple(named_effect(named, name) for name in added),
        tied=selection.ties if added else (),
        ranking=tuple(_ranked(question, base, s, selection) for s in selection.singles),
        not_visible=(*hidden, *(NotVisible(u.name, u.reason) for u in selection.unseen)),
        detectable=tuple(_detectable(question, selection)),
        calibration=calibration_of(named),
        noise_floor=floor.total,
        noise_floor_parts={"within": floor.within, "between": floor.between},
        noise_floor_source=floor.source,
        rmse_before=base.held_out.rmse,
        rmse_after=named.held_out.rmse,
        unit=question.data.unit,
        failures=(),
        unexplained=Unexplained(rest, _dependence(final, rivals, verdict)),
    )
    return Outcome(diagnosis, question, selection, rivals)


def _verdict(question: Question, selection: Selection, rivals: Sequence[Rival]) -> str:
    base, final = selection.base, selection.final
    if final is base:
        fails = material(question, base) and _fails(question, base, rivals)
        return UNEXPLAINED if fails else ADEQUATE
    near = final.held_out.rmse <= NEAR_FLOOR * question.floor.total
    little = excess(question, final) <= LEFT_OVER * excess(question, base)
    return EFFECTS_MISSING if near or little else UNEXPLAINED


def _fails(question: Question, scored: Scored, rivals: Sequence[Rival]) -> bool:
    """Whether the error is beyond the floor for certain: by repeats, or as a rival shows."""
    beaten = bool(rivals) and rivals[0].rmse < RIVAL_MARGIN * scored.held_out.rmse
    return beaten or scored.held_out.rmse > 1.2 * question.floor.upper


def _dependence(final: Scored, rivals: Sequence[Rival], verdict: str) -> tuple[str, ...]:
    """What the rest varies with: the rivals that beat the model, best first."""
    if verdict != UNEXPLAINED:
        return ()
    return tuple(r.name for r in rivals if r.rmse < RIVAL_MARGIN * final.held_out.rmse)[:3]


def named_effect(scored: Scored, effect: str) -> NamedEffect:
    """An effect of a fitted model with its parameters, errors and 95 % intervals."""
    parameters = scored.fit.problem.forward.parameters
    return NamedEffect(
        effect,
        {
            parameters[index].name.removeprefix(f"{effect}."): estimate(scored, index)
            for index in scored.parameters_of(effect)
        },
    )


def estimate(scored: Scored, index: int) -> Estimate:
    """One parameter of a fitted model; the interval allows for the few runs there are."""
    fitted, scales = scored.fit, scored.fit.problem.scales
    parameter = fitted.problem.forward.parameters[index]
    spread = float(np.sqrt(max(fitted.covariance[index, index], 0.0)))
    runs = len({part.run for part in fitted.problem.spectrum.layout.series})
    factor = float(student.ppf(CONFIDENCE, max(runs - len(fitted.values), 3)))
    center = scales.inward(fitted.values)
    ends = []
    for side in (-1.0, 1.0):
        moved = center.copy()
        moved[index] += side * factor * spread
        ends.append(float(scales.outward(np.clip(moved, scales.low, scales.high))[index]))
    value = float(fitted.values[index])
    std = value * spread if scales.logarithmic[index] else spread
    return Estimate(value, std, (ends[0], ends[1]), parameter.unit)


def calibration_of(scored: Scored) -> dict[str, Any]:
    """The fitted calibration as a model file holds it."""
    found: dict[str, Any] = {}
    parameters = scored.fit.problem.forward.parameters
    for parameter, value in zip(parameters, scored.fit.values.tolist(), strict=True):
        if parameter.effect is None:
            name, _, entry = parameter.name.partition("[")
            if entry:
                found.setdefault(name, {})[entry.rstrip("]")] = value
            else:
                found[name] = value
    return found


def _ranked(question: Question, base: Scored, scored: Scored, selection: Selection) -> Ranked:
    more = len(scored.fit.values) - len(base.fit.values)
    bic = scored.fit.deviance - base.fit.deviance + more * np.log(question.spectrum.layout.samples)
    return Ranked(
        scored.added,
        scored.held_out.rmse,
        float(bic),
        scored.plausible,
        selection.p_values[scored.added],
    )


def _detectable(question: Question, selection: Selection) -> list[Detectable]:
    """For each effect that could show, the weakest value of its first parameter that would have."""
    found = []
    for scored in selection.singles:
        effect = question.classes[scored.added]
        if effect.parameters and scored.signature is not None:
            smallest = _weakest(scored, selection.threshold, SMALLEST_SHOWN * question.floor.total)
            if smallest is not None:
                found.append(Detectable(effect.name, effect.parameters[0].name, smallest))
    return found


def _weakest(scored: Scored, threshold: float, material_size: float) -> float | None:
    """Value of the first parameter at which signature and size just suffice, between trials."""
    signature = scored.signature
    if signature is None:
        return None
    strength = np.minimum(
        np.sum(signature.change**2, axis=1) / threshold, (signature.size / material_size) ** 2
    )
    middle = np.all(signature.values[:, 1:] == _medians(signature.values[:, 1:]), axis=1)
    values, strength = signature.values[middle, 0], strength[middle]
    shown = np.flatnonzero(strength >= 1.0)
    if not len(shown):
        return None
    weakest = int(shown[np.argmin(strength[shown])])
    hidden = np.flatnonzero(strength < 1.0)
    if not len(hidden):
        return float(values[weakest])
    other = int(hidden[np.argmax(strength[hidden])])
    share = np.log(strength[weakest]) / np.log(strength[weakest] / strength[other])
    return float(values[weakest] + share * (values[other] - values[weakest]))


def _medians(values: Array) -> Array:
    """Middle trial value (k,) of each column, one of those that occur."""
    return np.array([np.unique(column)[len(np.unique(column)) // 2] for column in values.T])
