"""Diagnosis of a model against a measurement set: which effects are missing."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from model_lab.aliases import Tell, tell_nobody
from model_lab.diagnosis.black_boxes import black_boxes_of
from model_lab.diagnosis.criteria import (
    explains_all,
    lowers,
    material,
    verdict_of,
)
from model_lab.diagnosis.described import Outcome, described
from model_lab.diagnosis.error_by_step import (
    greater_part,
    helping,
)
from model_lab.diagnosis.first_look import TellFirst, first_look, tell_no_first
from model_lab.diagnosis.forward_selection import closer
from model_lab.diagnosis.judgement import Judgement
from model_lab.diagnosis.limited_sensor import with_limit, without_limit
from model_lab.diagnosis.new_specimens import as_new, with_new_specimens
from model_lab.diagnosis.own_moduli import may_differ, with_batches, with_own_moduli
from model_lab.diagnosis.own_sizes import other_sizes, with_other_size
from model_lab.diagnosis.result import (
    ADEQUATE,
    EFFECTS_MISSING,
    FLOOR_REASONS,
    LOWERED,
    MENDED,
    SLIP,
    THINNED,
    UNEXPLAINED,
    WITHOUT_EVENTS,
    Diagnosis,
    NotVisible,
)
from model_lab.diagnosis.run_left_out import without_odd_run
from model_lab.diagnosis.search import Scored, score_base, score_with
from model_lab.diagnosis.selection import (
    Selection,
    finer_forms,
    select,
    with_final,
    with_finer_ties,
)
from model_lab.diagnosis.slip_beside_effect import find_all_slips
from model_lab.diagnosis.suspect_series import Faults, judged_series
from model_lab.experiments.forward import not_searched
from model_lab.experiments.grasp_rollouts import use_processes
from model_lab.experiments.hand_pose import HAND_WEIGHT
from model_lab.fitting.problem import (
    FitProblem,
    pose_problem,
    with_lower_floor,
)
from model_lab.measurements.hands import HAND_POSE
from model_lab.measurements.load import load_measurements
from model_lab.measurements.measurement_set import MeasurementSet
from model_lab.measurements.preprocess import thinned
from model_lab.measurements.specimens import DOCUMENT
from model_lab.rules import RULES
from model_lab.slips.factor import acts_as_factor, factor_left, is_mere_factor
from model_lab.slips.find import SLIP_SAMPLES, Checked
from model_lab.slips.outside import outside
from model_lab.slips.slip import Slip
from softhand_model.effects import Effect, effect_classes
from softhand_model.model_file import Model, load_model


def diagnose(
    data: MeasurementSet,
    model: Model,
    classes: Mapping[str, type[Effect]] | None = None,
    seed: int = 0,
    jobs: int = 1,
    tell: Tell = tell_nobody,
    tell_first: TellFirst = tell_no_first,
) -> Outcome:
    """Compare a model with a measurement set, search for the effects that it lacks, and judge what
    is left.

    First the data are searched for slips (mistakes in how the data are stated) and for events in
    the series of runs, which are then taken out of the data. If the model fails, samples whose
    input is at the limit of its sensor are left out; if no effect explains the set, each
    specimen is given a modulus of its own where the error depends on the specimen, and each run a
    new specimen where softening then explains it. Long recordings are thinned. Effects of the model
    that have standard errors are fitted again, the others keep their values.

    Args:
        data: the measurement set.
        model: the model to judge.
        classes: effects to search, by name; None: the built-in ones.
        seed: seed of all random draws; the same seed gives the same answer.
        jobs: number of processes.
        tell: called with each step of the work, for a progress bar.
        tell_first: called once, before the search, with the first look.

    Raises ValueError for data that the model cannot use.
    """
    use_processes(jobs)
    known = effect_classes() if classes is None else classes
    options = _Options(known, seed, jobs, tell)
    outcome = _diagnosed(data, model, options, tell_first)
    limited = without_limit(data, outcome.diagnosis)
    if limited is not None:
        parted = _diagnosed(limited[0], model, options, tell_no_first)
        told = with_limit(data, outcome.diagnosis, parted.diagnosis, limited[1])
        if told is not None:
            return replace(parted, diagnosis=told)
    batches = may_differ(data, outcome.diagnosis)
    if batches:
        parted = _diagnosed(with_batches(data, batches), model, options, tell_no_first)
        told = with_own_moduli(data, outcome.diagnosis, batches, parted.diagnosis)
        if told is not None:
            return replace(parted, diagnosis=told)
    sizes = other_sizes(data, outcome.diagnosis, model)
    if sizes:
        resized = _diagnosed(sizes[0].mended, model, options, tell_no_first)
        told = with_other_size(outcome.diagnosis, sizes, resized.diagnosis)
        if told is not None:
            return replace(resized, diagnosis=told)
    new = as_new(data, outcome.diagnosis, model, known)
    if new is None:
        return outcome
    renewed = _diagnosed(new, model, options, tell_no_first)
    told = with_new_specimens(data, outcome.diagnosis, renewed.diagnosis, known)
    return outcome if told is None else replace(renewed, diagnosis=told)


@dataclass(frozen=True)
class _Options:
    """How to search: arguments of `diagnose`."""

    classes: Mapping[str, type[Effect]]
    seed: int
    jobs: int
    tell: Tell


def _diagnosed(
    data: MeasurementSet, model: Model, options: _Options, tell_first: TellFirst
) -> Outcome:
    """The diagnosis of a set with the batches that it states; raises ValueError as `diagnose`."""
    known, seed, jobs, tell = options.classes, options.seed, options.jobs, options.tell
    checked = find_all_slips(data, model, known, tell)
    why_not = outside(checked.data, model.base)
    if why_not is not None:
        raise ValueError(f"{data.folder / DOCUMENT}: {why_not}")

    def pose(measured: MeasurementSet) -> tuple[FitProblem, list[str]]:
        tell("fitting the model as it is", 0, 0)
        whole, posed = thinned(measured), checked.problem
        if posed is None or whole is not checked.data:
            problem, effects = pose_problem(whole, model, known)
            posed = replace(problem, known={}), effects
        problem, given = posed[0], [effect.name for effect in posed[1]]
        if measured is checked.data:
            plain = [n for n in candidates_of(problem, model)[0] if not problem.classes[n].refines]
            tell_first(first_look(problem, score_base(problem, given), plain, checked.slips))
        return problem, given

    def judge(problem: FitProblem, given: Sequence[str]) -> Judgement:
        search = partial(select, given=given, seed=seed, jobs=jobs, tell=tell)
        return searched(problem, candidates_of(problem, model)[0], search, tell)

    judged, faults = judged_series(
        checked.data, pose, lambda problem: candidates_of(problem, model)[0], judge
    )
    if not faults.events:
        judged, faults = without_odd_run(checked.data, judged, pose, judge) or (judged, faults)
    absent = candidates_of(judged.problem, model)[1]
    outcome = described(judged, absent, seed, faults.doubted is not None)
    instead = _instead(data, model, known, checked) if checked.slips else ()
    slips = [replace(slip, factor=_factor_left(judged, slip)) for slip in checked.slips]
    found = _with_faults(outcome, faults, slips, instead)
    reasons = _floor_reasons(judged.problem, found.diagnosis, checked.data)
    return replace(found, diagnosis=replace(found.diagnosis, floor_reasons=reasons))


def _factor_left(judged: Judgement, slip: Slip) -> float:
    """The factor that the corrected data still lack, without effects that only take it up."""
    if not is_mere_factor(slip.name, slip.column):
        return 1.0
    data = judged.problem.data
    base, named = (
        data.table.value - scored.fit.residual for scored in (judged.selection.base, judged.named)
    )
    return factor_left(data, base if acts_as_factor(base, named) else named)


def _floor_reasons(
    problem: FitProblem, found: Diagnosis, stated: MeasurementSet
) -> tuple[str, ...]:
    """Why the floor of a diagnosis is not the one that `compare` prints of the same set; stated:
    the set before long runs were thinned.
    """
    holds = {
        LOWERED: problem.floor_as_is is not None,
        MENDED: bool(found.slips),
        WITHOUT_EVENTS: bool(found.events),
        THINNED: thinned(stated) is not stated,
    }
    return tuple(reason for reason in FLOOR_REASONS if holds[reason])


def _with_faults(
    outcome: Outcome, faults: Faults, slips: Sequence[Slip], instead: tuple[str, ...]
) -> Outcome:
    """The diagnosis of a set without slips and without what happened in its series, with these, and
    the effects that would explain the same instead of the slips.
    """
    mended, every = outcome.diagnosis, (*slips, *faults.slips)
    if not every and not faults.events:
        return outcome
    verdict = UNEXPLAINED if mended.verdict == ADEQUATE else mended.verdict
    if any(slip.factor != 1.0 for slip in slips):
        mended = replace(mended, confidence=None, guess=True, beyond=())
    told = replace(
        mended,
        verdict=SLIP if every else verdict,
        slips=every,
        events=tuple(event.as_json() for event in faults.events),
        verdict_mended=mended.verdict,
        instead=instead,
    )
    return replace(outcome, diagnosis=told)


def _instead(
    data: MeasurementSet, model: Model, classes: Mapping[str, type[Effect]], checked: Checked
) -> tuple[str, ...]:
    """Effects without memory that explain the data as stated as well as the slips do."""
    try:
        problem, given = pose_problem(thinned(data, 1, SLIP_SAMPLES), model, classes)
        base = score_base(problem, [effect.name for effect in given])
    except ValueError:  # what the model cannot use, no effect explains
        return ()
    size = float(np.sqrt(np.mean(problem.data.table.value**2)))
    most = RULES.slip_alike * checked.relative_error
    known = problem.classes
    plain = [name for name in candidates_of(problem, model)[0] if not known[name].has_memory]
    tried = [score_with(problem, base, name) for name in plain if not known[name].refines]
    alone = (
        scored.added
        for scored in tried
        if isinstance(scored, Scored) and scored.plausible and scored.held_out.rmse <= most * size
    )
    return (*checked.instead, *alone)


Search = Callable[..., Selection]
"""`select` with all but the problem and the effects."""


def searched(
    problem: FitProblem, candidates: Sequence[str], search: Search, tell: Tell = tell_nobody
) -> Judgement:
    """The judgement on a search among the candidates, names of effects.

    The first search leaves out effects that are finer forms of others (whose `Effect.refines` names
    those). If the first search explains nothing, or leaves an error above the noise floor
    (`Rules.material_error`), or names several effects where a finer form of one explains the data
    alone, a second search is among all candidates. The judgement is that of the
    second search if only that explains the data, or does so with a clearly smaller error or fewer
    effects. Otherwise it is that of the first, with finer forms that explain as much as a named
    effect tied with it.
    """
    plain = [name for name in candidates if not problem.classes[name].refines]
    first = _judged_search(problem, plain, search, tell)
    if len(plain) == len(candidates):
        return first
    refined = [name for name in candidates if name not in plain]
    if _falls_short(first) or _is_one_finer(first, refined, candidates):
        finer = _judged_search(problem, candidates, search, tell)
        if _is_better(finer, first):
            return finer
    return replace(first, selection=with_finer_ties(first.problem, first.selection, refined))


def _falls_short(judged: Judgement) -> bool:
    """Whether plain effects leave so much that their refined forms are worth a try."""
    much = material(judged.problem, judged.named)
    return judged.verdict == UNEXPLAINED or (judged.verdict == EFFECTS_MISSING and much)


def _is_one_finer(judged: Judgement, refined: Sequence[str], candidates: Sequence[str]) -> bool:
    """Whether a finer form of one of several named effects explains the data alone, or, at a place
    of a hand, with another effect of the same place: a sensor may be off in scale and zero.
    """
    if len(judged.added) < 2:
        return False
    problem, base = judged.problem, judged.selection.base
    finer = finer_forms(problem, refined, judged.added)
    tried = [one for name in finer if (one := _explaining(problem, base, name)) is not None]
    best = min(tried, key=lambda one: one.held_out.rmse, default=None)
    if best is None or not material(problem, best):
        return best is not None
    beside = [name for name in candidates if _at_one_place(problem, name, best.added)]
    pairs = (_explaining(problem, best, name) for name in beside)
    return any(pair is not None and not material(problem, pair) for pair in pairs)


def _explaining(problem: FitProblem, before: Scored, name: str) -> Scored | None:
    """The model with one more effect, if its parameters are plausible."""
    scored = score_with(problem, before, name)
    return scored if isinstance(scored, Scored) and scored.plausible else None


def _at_one_place(problem: FitProblem, one: str, other: str) -> bool:
    """Whether two effects of a hand act at the same place."""
    first, second = (getattr(problem.classes[name], "where", {}) for name in (one, other))
    return one != other and bool(first) and first == second


def _is_better(finer: Judgement, plain: Judgement) -> bool:
    """Whether refined effects explain what plain ones do not, or more, or with fewer effects, or of
    a hand with as many and fewer parameters.
    """
    if UNEXPLAINED in (finer.verdict, plain.verdict):
        return plain.verdict == UNEXPLAINED
    of_hand = plain.problem.data.of_hand
    first, second = (
        (len(one.added), len(one.named.fit.values) if of_hand else 0) for one in (finer, plain)
    )
    return first < second or lowers(plain.problem, finer.named, plain.named)


def _judged_search(
    problem: FitProblem, effects: Sequence[str], search: Search, tell: Tell
) -> Judgement:
    """The judgement on a search. It is repeated with a lower noise floor where the best single
    effect, or the final model, lowers the floor.
    """
    selection = search(problem, effects)
    for of_several in (False, True):
        alone = next(iter(selection.proven), selection.base)
        lower = with_lower_floor(problem, (selection.final if of_several else alone).fit)
        if lower is not None:
            problem, selection = lower, search(lower, effects)
    tell("judging what is left", 0, 0)
    if selection.final is not selection.base:
        nearer = replace(selection.forward, final=closer(problem, selection.final))
        selection = replace(selection, forward=nearer)
    base, final = selection.base, selection.final
    black_boxes = black_boxes_of(problem, base, final)
    verdict = verdict_of(problem, base, final, black_boxes)
    helped = helping(problem, base, selection.forward) if verdict == UNEXPLAINED else ()
    if helped and explains_all(problem, helped[-1]):
        selection = with_final(problem, selection, helped[-1])
        verdict, final, helped = EFFECTS_MISSING, selection.final, ()
        black_boxes = black_boxes_of(problem, base, final)
    named = final if verdict == EFFECTS_MISSING else base
    greater = verdict == UNEXPLAINED and not helped
    most = greater_part(problem, base, selection.proven) if greater else ()
    return Judgement(problem, selection, black_boxes, verdict, named, helped, most)


def candidates_of(problem: FitProblem, model: Model) -> tuple[list[str], list[NotVisible]]:
    """(names of effects that could be missing, effects that the specimens may have but that cannot
    show in this set with the reason). Built-in effects of other experiments are in neither, nor are
    those that need another effect in the model.
    """
    present, data = {effect.name for effect in model.effects}, problem.data
    if data.experiment == HAND_POSE and HAND_WEIGHT not in model.std:
        present -= {HAND_WEIGHT}
    built_in = effect_classes()
    absent = {
        name: not_searched(effect, data, model.base)
        for name, effect in problem.classes.items()
        if name not in present
        and effect.physical
        and (not effect.beside or present & set(effect.beside))
        and (name not in built_in or data.experiment in {*effect.experiments, *effect.unseen_in})
    }
    candidates = [name for name, reason in absent.items() if reason is None]
    return candidates, [NotVisible(name, reason) for name, reason in absent.items() if reason]


def diagnose_folder(
    folder: str | Path, model: str | Path = "base", seed: int = 0, jobs: int = 1
) -> dict[str, Any]:
    """The diagnosis of a measurement set on disk, as the dictionary that `--json` writes."""
    outcome = diagnose(load_measurements(folder), load_model(model), seed=seed, jobs=jobs)
    return outcome.diagnosis.as_json()
