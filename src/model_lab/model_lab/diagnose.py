"""Diagnosis of a model against a measurement set: what is missing, as far as the data can tell."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.stats import f as variance_ratio
from scipy.stats import t as student

from model_lab.axes import axes_of
from model_lab.candidates import inapplicable, names
from model_lab.diagnosis import (
    ADEQUATE,
    EFFECTS_MISSING,
    UNEXPLAINED,
    Detectable,
    Diagnosis,
    Estimate,
    Failure,
    NamedEffect,
    NotVisible,
    Ranked,
    Unexplained,
)
from model_lab.fit import Problem, fit
from model_lab.forward import Forward
from model_lab.input_noise import steadied
from model_lab.loading import load_measurements
from model_lab.localise import Localisation, localise
from model_lab.measurement import MeasurementSet
from model_lab.noise import noise_floor
from model_lab.plan import proposal
from model_lab.rivals import Rival, fit_rivals
from model_lab.search import Question, Scored, base_starts
from model_lab.selection import Selection, error_of, excess, material, select
from model_lab.series import series_of
from model_lab.spectrum import make_spectrum
from model_lab.thinning import thinned
from softhand_model.effects import Effect, effect_classes
from softhand_model.model_file import Model, load_model

Array = NDArray[np.float64]

NEAR_FLOOR = 1.3  # held-out error over the floor that counts as explained
LEFT_OVER = 0.35  # share of the excess error that an effect of another form may leave
LEFT_OVER_OF_KIND = 0.4  # the same where the rest depends on memory, or not, as the effect does
LEFT_OVER_MENDED = 0.45  # the same where a black box of its kind explains the rest
MERE_REST = 0.2  # the same whatever the calibration
RIVAL_REST = 0.15  # error that such a black box may leave, over the error before
STILL_NEAR = 5.0  # held-out error over the floor beyond which nothing counts as explained
RIVAL_MARGIN = 0.85  # held-out error of a black box over the model's, below which it knows more
RIVAL_FAR = 0.65  # the same where the model is within the floor
SHAPE_MARGIN = 1.25  # held-out error but for gains over a floor that knows nothing of gains
LIKELY = 0.02  # chance from which on they are taken for it
SURE = 5e-3  # chance at which errors are taken to exceed the scatter of repeats
LOWER = 0.9  # floor after an effect over the floor before, from which on the lower one holds
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
    standard errors are fitted along, the others stay as they are. Same seed, same answer. Long
    recordings are thinned. Raises ValueError for data that the model cannot use.
    """
    data = thinned(data)
    question, given = pose_question(data, model, effect_classes() if classes is None else classes)
    present = {effect.name for effect in model.effects}
    hidden, tried = [], []
    for name, effect in question.classes.items():
        if name in present or not effect.physical:
            continue
        reason = inapplicable(effect, data, model.base)
        if reason is None:
            tried.append(name)
        else:
            hidden.append(NotVisible(name, reason))
    fitted = [effect.name for effect in given]
    selection = select(question, tried, fitted, seed, jobs)
    sharper = _sharper(question, selection)
    if sharper is not None:
        question, selection = sharper, select(sharper, tried, fitted, seed, jobs)
    return _outcome(question, selection, hidden, seed)


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

    The floor is seen from the residual of the model as it is, with its calibration fitted. Noise of
    the input is taken off first.
    """
    data = steadied(data)
    given = tuple(effect for effect in model.effects if effect.name in model.std)
    fixed = tuple(effect for effect in model.effects if effect.name not in model.std)
    known = {**classes, **{effect.name: type(effect) for effect in given}}
    forward = Forward(data, model.base, [type(effect) for effect in given], fixed)
    starts = base_starts(forward.parameters)
    layout = series_of(data)
    predicted = forward.predict(starts[:1])[0]
    spectrum = make_spectrum(layout, predicted)
    rough = noise_floor(data, spectrum, forward.measured - predicted)
    better = fit(Problem(forward, spectrum, rough.variance, rough.gain_known), starts)
    spectrum = make_spectrum(layout, forward.measured - better.residual)
    floor = noise_floor(data, spectrum, better.residual)
    return Question(data, model.base, fixed, known, spectrum, floor), given


def _sharper(question: Question, selection: Selection) -> Question | None:
    """The question with the floor below the best single effect, where that is clearly lower."""
    proven = [s for s in selection.singles if s.plausible and s.improvement > selection.threshold]
    return sharper(question, proven[0]) if proven else None


def sharper(question: Question, scored: Scored) -> Question | None:
    """The question with the floor below a better model, where that is clearly lower.

    Repeats may differ by an effect, such as what earlier runs have left in the rubber.
    """
    floor = noise_floor(question.data, question.spectrum, scored.fit.residual)
    return replace(question, floor=floor) if floor.total < LOWER * question.floor.total else None


def _outcome(
    question: Question, selection: Selection, hidden: list[NotVisible], seed: int
) -> Outcome:
    base, final = selection.base, selection.final
    predicted = base.fit.problem.forward.measured - base.fit.residual
    rivals = tuple(fit_rivals(final.fit, question.data, predicted))
    verdict = _verdict(question, selection, rivals)
    named = final if verdict == EFFECTS_MISSING else base
    added = [name for name in named.effects if name not in base.effects]
    floor = question.floor
    rest = excess(question, final)
    localised = localise(question.data, base.held_out.residual, seed)
    failures = tuple(
        Failure(axis.against, axis.where, axis.p_value, axis.share_of_error)
        for axis in localised.failures
    )
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
        failures=failures,
        next_experiment=proposal(question, named, selection.ties) if added else None,
        correlation=correlation_of(named),
        unexplained=Unexplained(
            rest, _dependence(question.data, final, rivals, localised, verdict)
        ),
    )
    return Outcome(diagnosis, question, selection, rivals)


def _verdict(question: Question, selection: Selection, rivals: Sequence[Rival]) -> str:
    base, final = selection.base, selection.final
    if final is base:
        return UNEXPLAINED if _fails(question, base, rivals) else ADEQUATE
    near = error_of(question, final) <= NEAR_FLOOR * question.floor.total
    if not near and question.floor.gain_known:
        near = _beyond_repeats(question, final) >= LIKELY
    explained = near or _another_form(question, base, final, rivals)
    return EFFECTS_MISSING if explained else UNEXPLAINED


def _another_form(question: Question, base: Scored, final: Scored, rivals: Sequence[Rival]) -> bool:
    """Whether effects explain the error but for what another equation for them would change.

    That is little; or somewhat more, if a black box that remembers, or not, as they do, takes it
    down to the floor.
    """
    floor = question.floor.total
    share = excess(question, final) / excess(question, base)
    error = error_of(question, final)
    if share <= MERE_REST and error <= STILL_NEAR * floor:
        return True
    if error > STILL_NEAR * floor or bool(np.any(final.fit.at_limit)):
        return False
    remembers = any(question.classes[name].has_memory for name in final.effects)
    if not rivals or rivals[0].remembers != remembers:
        return share <= LEFT_OVER
    mended = rivals[0].rmse <= max(NEAR_FLOOR * floor, RIVAL_REST * error_of(question, base))
    return share <= (LEFT_OVER_MENDED if mended else LEFT_OVER_OF_KIND)


def _fails(question: Question, scored: Scored, rivals: Sequence[Rival]) -> bool:
    """Whether the error is beyond the floor for certain: by repeats, or as a rival shows.

    A rival that is far better counts even where repeats scatter as much as the model errs.
    """
    if scored.held_out.rmse <= question.floor.total:
        return False
    if rivals and rivals[0].rmse < RIVAL_FAR * scored.held_out.rmse:
        return True
    if not material(question, scored):
        return False
    if question.floor.gain_known:
        return _beyond_repeats(question, scored) < SURE
    return _shape_error(question, scored) > SHAPE_MARGIN * question.floor.total


def _shape_error(question: Question, scored: Scored) -> float:
    """Held-out root mean square error but for the gains of runs, of which nothing is known."""
    spectrum = question.spectrum
    power = spectrum.power(spectrum.coefficients(scored.held_out.residual[None]))[0]
    gains = np.searchsorted(spectrum.band_output, np.unique(spectrum.band_output))
    power[gains] = 0.0
    return float(np.sqrt(power.sum() / spectrum.counts().sum()))


def _beyond_repeats(question: Question, scored: Scored) -> float:
    """Chance (p-value) at which held-out errors exceed the scatter of repeats, over all bands."""
    spectrum, floor = question.spectrum, question.floor
    power = spectrum.power(spectrum.coefficients(scored.held_out.residual[None]))[0]
    counts = spectrum.counts()
    runs = len(question.data.runs)
    allowed = 1.0 + len(scored.fit.values) / max(runs - len(scored.fit.values), 1)
    seen = floor.dof > 0.0
    ratio = power[seen] / counts[seen] / (allowed * floor.variance[seen])
    chances = variance_ratio.sf(ratio, counts[seen], floor.dof[seen])
    return float(min(np.min(chances) * len(chances), 1.0))


def _dependence(
    data: MeasurementSet,
    final: Scored,
    rivals: Sequence[Rival],
    localised: Localisation,
    verdict: str,
) -> tuple[str, ...]:
    """What the rest varies with: the rivals that beat the model, best first; else the axes against
    which the model fails, or the one that comes nearest to that.
    """
    if verdict != UNEXPLAINED:
        return ()
    varied = {axis.name for axis in axes_of(data)}
    beaten = [
        rival.against
        for rival in rivals
        if rival.rmse < RIVAL_MARGIN * final.held_out.rmse and rival.against in varied
    ]
    failing = localised.failures or localised.axes[:1]
    return tuple(dict.fromkeys(beaten or [axis.against for axis in failing]))[:3]


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


def correlation_of(scored: Scored) -> dict[str, dict[str, float]]:
    """Correlation of every two parameters of a fitted model, by their names."""
    spread = np.sqrt(np.maximum(np.diag(scored.fit.covariance), 0.0))
    size = np.where(spread > 0.0, spread, 1.0)
    matrix = scored.fit.covariance / np.outer(size, size)
    known = names(scored.fit.problem)
    return {
        a: dict(zip(known, row, strict=True)) for a, row in zip(known, matrix.tolist(), strict=True)
    }


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
