"""Diagnosis of a model against a measurement set: what is missing, as far as the data can tell."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from model_lab.aliases import Tell, tell_nobody
from model_lab.diagnosis.black_boxes import BlackBox, fit_black_boxes
from model_lab.diagnosis.confidence import confidence_of
from model_lab.diagnosis.errors import excess
from model_lab.diagnosis.evidence import evidence_of
from model_lab.diagnosis.next_experiment import proposal
from model_lab.diagnosis.result import (
    EFFECTS_MISSING,
    LEFT_OVER,
    UNEXPLAINED,
    Diagnosis,
    Failure,
    Help,
    NotVisible,
    Ranked,
    Unexplained,
    calibration_of,
    correlation_of,
    modulus_of,
    named_effect,
)
from model_lab.diagnosis.search import Scored
from model_lab.diagnosis.selection import Selection, detectable_effects, select
from model_lab.diagnosis.story import helping, story
from model_lab.diagnosis.verdict import depends_on, verdict_of
from model_lab.experiments.forward import not_searched
from model_lab.fitting.notices import Notice, notices
from model_lab.fitting.problem import FitProblem, pose_problem, with_lower_floor
from model_lab.localisation.localise import Localisation, localise
from model_lab.measurements.load import load_measurements
from model_lab.measurements.measurement_set import MeasurementSet
from model_lab.measurements.preprocess import thinned
from softhand_model.effects import Effect, effect_classes
from softhand_model.model_file import Model, load_model

WORTH_FINER = 2.0  # error after over the noise floor
NOT_ALL = 0.94  # most confidence in effects that leave LEFT_OVER floors of what was held out


@dataclass(frozen=True)
class Outcome:
    """A diagnosis with what it was drawn from, for reports."""

    diagnosis: Diagnosis
    problem: FitProblem
    selection: Selection
    black_boxes: tuple[BlackBox, ...]
    notices: tuple[Notice, ...] = ()


def diagnose(
    data: MeasurementSet,
    model: Model,
    classes: Mapping[str, type[Effect]] | None = None,
    seed: int = 0,
    jobs: int = 1,
    tell: Tell = tell_nobody,
) -> Outcome:
    """Compare a model with a set, search the effects for what is missing, and judge the rest.

    classes: effects that take part, the built-in ones if None. Effects of the model file that carry
    standard errors are fitted along, the others stay as they are. Same seed, same answer. Long
    recordings are thinned. Raises ValueError for data that the model cannot use.
    """
    tell("fitting the model as it is", 0, 0)
    known = effect_classes() if classes is None else classes
    problem, given = pose_problem(thinned(data), model, known)
    candidates, hidden = _candidates(problem, model)
    plain = [name for name in candidates if not problem.classes[name].refines]
    search = partial(
        select, given=[effect.name for effect in given], seed=seed, jobs=jobs, tell=tell
    )
    outcome = _searched(problem, partial(search, effects=plain), hidden, seed, tell)
    if len(plain) == len(candidates) or not _falls_short(outcome.diagnosis):
        return outcome
    finer = _searched(problem, partial(search, effects=candidates), hidden, seed, tell)
    only_finer_fails = finer.diagnosis.verdict == UNEXPLAINED != outcome.diagnosis.verdict
    return outcome if only_finer_fails else finer


def _falls_short(diagnosis: Diagnosis) -> bool:
    """Whether plain effects leave so much that their finer forms are worth a try."""
    left = diagnosis.rmse_after > WORTH_FINER * diagnosis.noise_floor
    return diagnosis.verdict == UNEXPLAINED or (diagnosis.verdict == EFFECTS_MISSING and left)


def _searched(
    problem: FitProblem,
    search: Callable[[FitProblem], Selection],
    hidden: list[NotVisible],
    seed: int,
    tell: Tell,
) -> Outcome:
    """The outcome of a search, which is done again where its best effect lowers the floor, and
    where what it has found does so once more.
    """
    selection = search(problem)
    for best in (_best_alone, _found):
        lower = with_lower_floor(problem, best(selection).fit)
        if lower is not None:
            problem, selection = lower, search(lower)
    tell("judging what is left", 0, 0)
    return _judged(problem, selection, hidden, seed)


def _best_alone(selection: Selection) -> Scored:
    """The best proven effect beside the base, or the base."""
    return next(iter(selection.proven), selection.base)


def _found(selection: Selection) -> Scored:
    """The model with all that was found."""
    return selection.final


def _candidates(problem: FitProblem, model: Model) -> tuple[list[str], list[NotVisible]]:
    """Effects that could be missing, and those that cannot show in this set at all."""
    present = {effect.name for effect in model.effects}
    absent = {
        name: not_searched(effect, problem.data, model.base)
        for name, effect in problem.classes.items()
        if name not in present and effect.physical
    }
    candidates = [name for name, reason in absent.items() if reason is None]
    return candidates, [NotVisible(name, reason) for name, reason in absent.items() if reason]


def diagnose_folder(
    folder: str | Path, model: str | Path = "base", seed: int = 0, jobs: int = 1
) -> dict[str, Any]:
    """The diagnosis of a measurement set on disk, as the dictionary that `--json` writes."""
    outcome = diagnose(load_measurements(folder), load_model(model), seed=seed, jobs=jobs)
    return outcome.diagnosis.as_json()


def _judged(
    problem: FitProblem, selection: Selection, hidden: list[NotVisible], seed: int
) -> Outcome:
    """The verdict, and all that the diagnosis says besides."""
    base, final = selection.base, selection.final
    black_boxes = _black_boxes(problem, base, final)
    verdict = verdict_of(problem, selection, black_boxes)
    named = final if verdict == EFFECTS_MISSING else base
    helped = helping(problem, base, selection.growth) if verdict == UNEXPLAINED else ()
    added = [name for name in named.effects if name not in base.effects]
    floor = problem.floor
    rest = excess(problem, named)
    left_over = bool(added) and named.held_out.rmse > LEFT_OVER * floor.total
    odd = notices(problem.data, floor, named.held_out.residual)
    localised = localise(problem.data, base.held_out.residual, seed)
    against: tuple[str, ...] = ()
    if helped:
        rest_of = helped[-1]
        left = localise(problem.data, rest_of.held_out.residual, seed)
        against = depends_on(problem.data, rest_of, _black_boxes(problem, base, rest_of), left)
    elif verdict == UNEXPLAINED:
        against = depends_on(problem.data, final, black_boxes, localised)
    elif left_over:
        left = localise(problem.data, named.held_out.residual, seed)
        against = depends_on(problem.data, named, black_boxes, left)
    evidence = evidence_of(problem, selection, black_boxes, len(odd))
    most = NOT_ALL if left_over else 1.0
    sure = confidence_of(problem.data.experiment, verdict, evidence, most)
    diagnosis = Diagnosis(
        experiment=problem.data.experiment,
        verdict=verdict,
        holdout=problem.data.table.holdout,
        effects=tuple(named_effect(named, name) for name in added),
        tied=selection.ties if added else (),
        ranking=tuple(_ranked(problem, base, s, selection) for s in selection.singles),
        not_visible=(*hidden, *(NotVisible(u.name, u.reason) for u in selection.unseen)),
        detectable=tuple(detectable_effects(problem, selection)),
        calibration=calibration_of(named),
        noise_floor=floor.total,
        noise_floor_parts={"within": floor.within, "between": floor.between},
        noise_floor_source=floor.source,
        rmse_before=base.held_out.rmse,
        rmse_after=named.held_out.rmse,
        unit=problem.data.unit,
        failures=_failures(localised),
        next_experiment=proposal(problem, named, selection.ties) if added else None,
        correlation=correlation_of(named),
        modulus=modulus_of(named, problem.data),
        unexplained=Unexplained(rest, against),
        story=story(problem, base, selection.growth) if added else (),
        notices=tuple(notice.as_json() for notice in odd),
        helps=tuple(Help(scored.added, scored.held_out.rmse) for scored in helped),
        confidence=sure.value,
        guess=sure.guess,
        evidence=evidence,
    )
    return Outcome(diagnosis, problem, selection, black_boxes, odd)


def _failures(localised: Localisation) -> tuple[Failure, ...]:
    """Where the model fails, as the diagnosis says it."""
    return tuple(
        Failure(axis.against, axis.where, axis.p_value, axis.share_of_error)
        for axis in localised.failures
    )


def _black_boxes(problem: FitProblem, base: Scored, scored: Scored) -> tuple[BlackBox, ...]:
    """What black boxes make of a model's rest, the best first."""
    predicted = problem.data.table.value - base.fit.residual
    return tuple(fit_black_boxes(scored.fit, problem.data, predicted))


def _ranked(problem: FitProblem, base: Scored, scored: Scored, selection: Selection) -> Ranked:
    more = len(scored.fit.values) - len(base.fit.values)
    bic = scored.fit.deviance - base.fit.deviance + more * np.log(problem.data.table.samples)
    return Ranked(
        scored.added,
        scored.held_out.rmse,
        float(bic),
        scored.plausible,
        selection.p_values[scored.added],
    )
