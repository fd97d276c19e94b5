"""A judgement as the diagnosis that is reported: the verdict, and what stands beside it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from model_lab.aliases import Array
from model_lab.diagnosis.black_boxes import BlackBox, black_boxes_of
from model_lab.diagnosis.confidence import confidence_of
from model_lab.diagnosis.criteria import depends_on, excess
from model_lab.diagnosis.error_by_step import error_by_step, share_removed
from model_lab.diagnosis.evidence import evidence_of
from model_lab.diagnosis.form_of_others import only_mending
from model_lab.diagnosis.judgement import Judgement
from model_lab.diagnosis.next_experiment import proposal
from model_lab.diagnosis.result import (
    ADEQUATE,
    REPEATS_APART,
    UNEXPLAINED,
    Diagnosis,
    Failure,
    GreaterPart,
    Help,
    NamedEffect,
    NotVisible,
    Ranked,
    Unexplained,
    calibration_at_bound,
    calibration_of,
    correlation_of,
    modulus_of,
    named_effect,
)
from model_lab.diagnosis.search import Scored, score_base
from model_lab.diagnosis.selection import Selection, detectable_effects
from model_lab.fitting.noise_floor import REPEATS, NoiseFloor
from model_lab.fitting.notice import Notice
from model_lab.fitting.notices import notices
from model_lab.fitting.problem import INTERPOLATED, FitProblem
from model_lab.localisation.localise import Localisation, localise
from model_lab.rules import RULES
from model_lab.series.within_runs import WithinRuns, residual_tests
from softhand_model.effects.hand import ActuatorScatter, HandEffect


@dataclass(frozen=True)
class Outcome:
    """A diagnosis with the fits and notices behind it, from which reports are made."""

    diagnosis: Diagnosis
    problem: FitProblem
    selection: Selection
    black_boxes: tuple[BlackBox, ...]
    notices: tuple[Notice, ...] = ()


def described(judged: Judgement, absent: list[NotVisible], seed: int, doubted: bool) -> Outcome:
    """The diagnosis: the verdict, and what is reported beside it. doubted: whether repeats may go
    with the order of the runs.
    """
    problem, selection, named = judged.problem, judged.selection, judged.named
    base, floor, added = selection.base, problem.floor, judged.added
    odd = notices(problem.data, floor, named.held_out.residual)
    localised = localise(problem.data, base.held_out.residual, seed)
    within = residual_tests(problem.data, named.fit.residual)
    failing = failing_axes(judged, localised, within, doubted, odd)
    verdict = UNEXPLAINED if failing else judged.verdict
    evidence = evidence_of(problem, selection, judged.black_boxes, len(odd))
    experiment = problem.data.experiment
    sure = confidence_of(experiment, verdict, evidence, judged.most_confidence, judged.at_bound)
    effects = _named_effects(judged, sure.value)
    apart = repeats_apart(floor, problem.data.table.value)
    if apart or any(effect.undetermined or effect.form_of for effect in effects):
        why = (REPEATS_APART,) if apart else sure.beyond
        sure = replace(sure, value=None, guess=True, beyond=why)
        effects = tuple(replace(effect, cause_confidence=None) for effect in effects)
    diagnosis = Diagnosis(
        experiment=problem.data.experiment,
        verdict=verdict,
        holdout=problem.data.table.holdout,
        effects=effects,
        tied=selection.ties if added else (),
        ranking=tuple(_ranked(problem, base, s, selection) for s in selection.singles),
        not_visible=(*absent, *(NotVisible(u.name, u.reason) for u in selection.unseen)),
        detectable=tuple(detectable_effects(problem, selection)),
        calibration=calibration_of(named),
        noise_floor=floor.total,
        noise_floor_parts={"within": floor.within, "between": floor.between},
        noise_floor_source=floor.source,
        noise_floor_as_is=(problem.floor_as_is or floor).total,
        rmse_before=base.held_out.rmse,
        rmse_after=named.held_out.rmse,
        unit=problem.data.unit,
        failures=_failures(localised),
        next_experiment=proposal(problem, named, selection.ties) if added else None,
        correlation=correlation_of(named),
        modulus=modulus_of(named, problem.data),
        unexplained=Unexplained(
            excess(problem, named), failing or _rest_against(judged, localised, seed)
        ),
        story=error_by_step(problem, base, selection.forward) if added else (),
        notices=tuple(notice.as_json() for notice in odd),
        helps=tuple(Help(scored.added, scored.held_out.rmse) for scored in judged.helping),
        greater_part=_greater_part(judged),
        confidence=sure.value,
        guess=sure.guess,
        beyond=sure.beyond,
        evidence=evidence,
        residual_tests=None if within is None else within.as_json(),
        at_bound=calibration_at_bound(base),
        calibration_as_is=calibration_of(base),
        freed=_freed(problem, base),
        channel=_channel_of(problem, effects),
        units=problem.data.units,
    )
    return Outcome(diagnosis, problem, selection, judged.black_boxes, odd)


def _channel_of(problem: FitProblem, effects: Sequence[NamedEffect]) -> str | None:
    """The channel of a hand that feeds just the actuators that are named as stiffer or softer."""
    kinds = [problem.classes[effect.name] for effect in effects]
    scattered = [kind for kind in kinds if issubclass(kind, ActuatorScatter)]
    if not effects or len(scattered) < len(kinds):
        return None
    hand, found = problem.data.hand, {kind.where["actuator"] for kind in scattered}
    fed: dict[str, set[str]] = {}
    for name in hand.actuator_names:
        fed.setdefault(hand.channels[hand.channel_of(name)], set()).add(name)
    return next((channel for channel, actuators in fed.items() if actuators == found), None)


def _freed(problem: FitProblem, base: Scored) -> dict[str, Any] | None:
    """Calibration and held-out error of the base with a free modulus, if its modulus lies on a
    bound beyond which models are computed.
    """
    bound = any(name.startswith("modulus_scale") for name in calibration_at_bound(base))
    if not bound or problem.data.experiment in INTERPOLATED:
        return None
    data = replace(problem.data, free_modulus=True)
    found = score_base(replace(problem, data=data, known=None), base.effects)
    return {**calibration_of(found), "rmse_heldout": found.held_out.rmse}


def _named_effects(judged: Judgement, confidence: float | None) -> tuple[NamedEffect, ...]:
    """The named effects with their classes of causes. A verdict counts as right if the truth is
    among what is tied: confidence is of the class only where nothing else is tied.
    """
    classes, found = judged.problem.classes, []
    mending = only_mending(judged.problem, judged.selection.base, judged.named)
    for name, tied in zip(judged.added, judged.selection.ties, strict=False):
        cause = classes[name].cause
        alike = [other for other in tied if cause and classes[other].cause == cause]
        members = {one: classes[one].member for one in [name, *alike]} if alike else {}
        sure = confidence if len(alike) == len(tied) else None
        effect = named_effect(judged.named, name)
        known = replace(effect, cause=cause, members=members, cause_confidence=sure)
        known = replace(known, form_of=mending.get(name, ()))
        kind = classes[name]
        if issubclass(kind, HandEffect):
            known = replace(known, kind=kind.kind, where=kind.where)
        found.append(known)
    return tuple(found)


def _greater_part(judged: Judgement) -> GreaterPart | None:
    """The effect that explains the greater part, where no effect is named."""
    if not judged.greater:
        return None
    best, problem = judged.greater[0], judged.problem
    share = share_removed(problem, best, judged.selection.base)
    cause = problem.classes[best.added].cause
    every = [one.added for one in judged.greater]
    members = [name for name in every if cause and problem.classes[name].cause == cause]
    known = {name: problem.classes[name].member for name in members} if len(members) > 1 else {}
    effect = replace(named_effect(best, best.added), cause=cause, members=known)
    others = tuple(name for name in every[1:] if name not in known)
    return GreaterPart(effect, others, best.held_out.rmse, share)


def repeats_apart(floor: NoiseFloor, outputs: Array) -> bool:
    """Whether repeats differ by so much more than the readings of one run that the noise floor may
    hide what happened between them. outputs (samples,): in the unit of the floor.
    """
    ratio, share = RULES.repeats_apart
    most = max(ratio * floor.within, share * float(np.std(outputs)))
    return floor.source == REPEATS and floor.between > most


def failing_axes(
    judged: Judgement,
    localised: Localisation,
    within: WithinRuns | None,
    doubted: bool,
    odd: Sequence[Notice],
) -> tuple[str, ...]:
    """Axes against which a model fails beyond chance and by much though its error lies within the
    noise floor: then it is not adequate. So is the order of the runs where repeats differ by about
    as much as the readings of one run do, and the time where most of the error oscillates: that
    raises the floor, and is no noise. Empty with any other verdict.
    """
    if judged.verdict != ADEQUATE:
        return ()
    floor = judged.problem.floor
    spread = float(np.std(judged.problem.data.table.value))
    doubted = doubted or (floor.source == REPEATS and floor.total > RULES.slip_noise * spread)
    failing = [axis.against for axis in localised.certain_failures]
    follows = ["pressure"] if within is not None and within.follows_input else []
    of_series = ["run_order"] if doubted else []
    lines = [notice.size for notice in odd if notice.kind == "line"]
    most = any(size > RULES.line_of_error * judged.named.held_out.rmse for size in lines)
    of_time = ["time_since_step"] if most else []
    return tuple(dict.fromkeys([*failing, *follows, *of_series, *of_time]))[:3]


def _rest_against(judged: Judgement, of_base: Localisation, seed: int) -> tuple[str, ...]:
    """Axes on which the rest depends: what the helping effects leave, else what the final model
    leaves; empty if that is little. of_base: localisation of the error of the base.
    """
    problem, selection, black_boxes = judged.problem, judged.selection, judged.black_boxes
    if judged.helping or judged.greater:
        scored = (*judged.greater[:1], *judged.helping)[-1]
        black_boxes = black_boxes_of(problem, selection.base, scored)
    elif judged.verdict == UNEXPLAINED:
        return depends_on(problem.data, selection.final, black_boxes, of_base)
    elif judged.leaves_much:
        scored = judged.named
    else:
        return ()
    localised = localise(problem.data, scored.held_out.residual, seed)
    return depends_on(problem.data, scored, black_boxes, localised)


def _failures(localised: Localisation) -> tuple[Failure, ...]:
    """Where the model fails, as the diagnosis says it."""
    return tuple(
        Failure(axis.against, axis.where, axis.p_value, axis.share_of_error)
        for axis in localised.failures
    )


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
