"""Selection of the missing effects: each alone, several (`forward_selection`), then their ties.

An effect is only named if it gains more than the best of all candidates does in pure noise, whose
distribution is found by random draws. This module also finds the smallest value of each effect that
would have been detected.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from model_lab.aliases import Array, Tell, tell_nobody
from model_lab.diagnosis.criteria import (
    error_of,
    excess,
    has_few_folds,
    is_far,
    leaves_more_than_noise,
    lowers,
)
from model_lab.diagnosis.forward_selection import (
    ForwardSelection,
    Search,
    criterion,
    proven,
    select_forward,
    with_own_held_out,
)
from model_lab.diagnosis.priors import EMPIRICAL, is_between_samples
from model_lab.diagnosis.result import Detectable
from model_lab.diagnosis.search import (
    Scored,
    Signature,
    Unseen,
    score_all,
    score_base,
    score_without,
)
from model_lab.fitting.fit import PSEUDO_OBSERVATIONS
from model_lab.fitting.noise_floor import Spectrum
from model_lab.fitting.problem import FitProblem

NOISE_DRAWS = 2000  # simulated sets of pure noise


@dataclass(frozen=True)
class Selection:
    """The search and its outcome.

    base: the model as it was. singles: the model with each effect alone. unseen: effects that
    cannot show. forward: models with several effects, and the chosen one. p_values: of the single
    effects, by name. threshold: least fall of the deviance that counts as more than noise. ties:
    for each effect of the final model, names of effects that explain as much in its place, the
    closest first.
    """

    base: Scored
    singles: tuple[Scored, ...]
    unseen: tuple[Unseen, ...]
    forward: ForwardSelection
    p_values: dict[str, float]
    threshold: float
    ties: tuple[tuple[str, ...], ...]

    @property
    def final(self) -> Scored:
        """The chosen model; the base if no effect is missing."""
        return self.forward.final

    @property
    def proven(self) -> list[Scored]:
        """Models with one effect that gain more than pure noise would, with plausible parameters,
        best first.
        """
        return proven(self.singles, self.threshold)


def select(
    problem: FitProblem,
    effects: Sequence[str],
    given: Sequence[str],
    seed: int,
    jobs: int,
    tell: Tell = tell_nobody,
) -> Selection:
    """Search among `effects` for those that are missing in a model that already has the `given`
    ones.
    """
    base = score_base(problem, given)
    search = partial(score_all, jobs=jobs, tell=tell)
    tried = search(problem, base, effects)
    singles = tuple(sorted((s for s in tried if isinstance(s, Scored)), key=criterion))
    unseen = tuple(s for s in tried if isinstance(s, Unseen))
    shown = [s for s in singles if s.signature]
    maxima = problem.once(
        lambda: null_maxima([s.signature for s in shown if s.signature], problem.spectrum, seed),
        "maxima",
        tuple(s.effects for s in shown),
        seed,
    )
    threshold = float(np.quantile(maxima, 1.0 - problem.rules.significance))
    p_values = {s.added: p_value(maxima, s.improvement) for s in singles}
    forward = select_forward(problem, base, singles, threshold, search)
    ties = _ties(problem, forward.final, base, singles, search)
    for _ in range(problem.rules.most_effects):
        better = _better_member(problem, forward.final, base, ties)
        better = better or _with_a_reason(problem, forward.final, base, ties)
        if better is None:
            break
        forward = replace(forward, final=better)
        ties = _ties(problem, better, base, singles, search)
    names = tuple(tuple(scored.added for scored in group) for group in ties)
    return Selection(base, singles, unseen, forward, p_values, threshold, names)


def with_final(
    problem: FitProblem, selection: Selection, final: Scored, jobs: int = 1
) -> Selection:
    """The selection with another model as the chosen one, and with its ties."""
    search = partial(score_all, jobs=jobs)
    ties = _ties(problem, final, selection.base, selection.singles, search)
    names = tuple(tuple(scored.added for scored in group) for group in ties)
    return replace(selection, forward=replace(selection.forward, final=final), ties=names)


def with_finer_ties(problem: FitProblem, selection: Selection, refined: Sequence[str]) -> Selection:
    """The selection, whose named effects are also tied with finer forms of them, of the `refined`
    effects, that explain as much; so many that a tie has at most `Rules.most_unusual_ties` names
    besides.
    """
    base, final = selection.base, selection.final
    added = [name for name in final.effects if name not in base.effects]
    finer = finer_forms(problem, refined, added)
    if not finer:
        return selection
    tried = [s for s in score_all(problem, base, finer) if isinstance(s, Scored)]
    ties = []
    every = _ties(problem, final, base, (*selection.singles, *tried), score_all)
    for effect, plain, group in zip(added, selection.ties, every, strict=True):
        more = finer_forms(problem, [s.added for s in group], [effect])
        free = max(0, problem.rules.most_unusual_ties - len(plain))
        ties.append((*plain, *more[:free]))
    return replace(selection, ties=tuple(ties))


def finer_forms(problem: FitProblem, refined: Sequence[str], named: Sequence[str]) -> list[str]:
    """Those of the `refined` effects that are finer forms of a named one, wherever it is."""
    kinds = {getattr(problem.classes[name], "kind", name) for name in named}
    return [name for name in refined if kinds & set(problem.classes[name].refines)]


def _better_member(
    problem: FitProblem, final: Scored, base: Scored, ties: Sequence[Sequence[Scored]]
) -> Scored | None:
    """The best model with another member of the same class of causes, if it has a smaller error."""
    causes = [problem.classes[name].cause for name in final.effects if name not in base.effects]
    alike = [
        scored
        for cause, group in zip(causes, ties, strict=True)
        for scored in group
        if cause and problem.classes[scored.added].cause == cause and scored.plausible
    ]
    best = min(alike, key=lambda scored: error_of(problem, scored), default=None)
    if best is None or error_of(problem, best) >= error_of(problem, final):
        return None
    return with_own_held_out(problem, best)


def _with_a_reason(
    problem: FitProblem, final: Scored, base: Scored, ties: Sequence[Sequence[Scored]]
) -> Scored | None:
    """The nearest model in which an effect that says why stands for one of `EMPIRICAL`, as well and
    with no more parameters.
    """
    added = [name for name in final.effects if name not in base.effects]
    for effect, group in zip(added, ties, strict=True):
        for other in group if effect in EMPIRICAL else ():
            new, old = (len(problem.classes[name].parameters) for name in (other.added, effect))
            alike = other.plausible and not lowers(problem, final, other)
            if other.added not in EMPIRICAL and alike and new <= old:
                return with_own_held_out(problem, other)
    return None


def _ties(
    problem: FitProblem, final: Scored, base: Scored, singles: Sequence[Scored], search: Search
) -> tuple[tuple[Scored, ...], ...]:
    """For each effect of the final model the models that explain as much in its place."""
    added = [name for name in final.effects if name not in base.effects]
    result = []
    for effect in added:
        without, instead = base, list(singles)
        if len(added) > 1:
            without = score_without(problem, final, effect)
            names = [s.added for s in singles if s.added not in final.effects]
            tried = search(problem, without, names, limit=problem.rules.fitted_beside)
            instead = [s for s in tried if isinstance(s, Scored)]
        others = sorted((s for s in instead if s.added != effect), key=criterion)
        result.append(_as_near(problem, effect, others, final, without))
    return tuple(result)


def _as_near(
    problem: FitProblem, effect: str, others: Sequence[Scored], final: Scored, without: Scored
) -> tuple[Scored, ...]:
    """Models, nearest first, that explain as much as the final one beyond the one without an
    effect; and few that would with unusual parameters, or but for the form of an equation. Models
    that are unlikely a priori, or whose error is far larger, are left out; so are other forms whose
    fit is off by more than noise and explains too little, where the final model's is within noise.

    Few are names or, where what explains the data happens between their samples, causes: how well
    each of them fits then depends on an input that was not recorded.
    """
    gained = criterion(without) - criterion(final)
    rules = problem.rules
    largest = rules.tie_error * max(error_of(problem, final), problem.floor.total)
    stands_for = problem.classes[effect].stands_for
    forms = {s.added for s in others if s.added in stands_for and _up_to_form(problem, s, without)}
    near_enough = [s for s in others if s.added in forms or error_of(problem, s) <= largest]
    likely = [s for s in near_enough if s.unusual - final.unusual < rules.tie_deviance]
    behind = {s.added: criterion(s) - criterion(final) for s in likely}
    most = rules.tie_deviance
    equal = [s for s in likely if behind[s.added] < most or _as_good(problem, s, final)]
    fits = {effect: final.fit, **{s.added: s.fit for s in equal}}
    unseen = any(
        is_between_samples(problem.data, fit, problem.classes[name]) for name, fit in fits.items()
    )

    def is_free() -> bool:
        others = _other_causes(problem, effect, tied) if unseen else tied
        return len(others) < rules.most_unusual_ties

    tied = [s.added for s in equal if s.unusual - final.unusual < rules.tie_unusual]
    for scored in equal:
        if scored.added not in tied and is_free():
            tied.append(scored.added)
    of_another_form = leaves_more_than_noise(problem, final)
    share = rules.tie_share_unresolved if unseen else rules.tie_share_other_form
    for scored in sorted(likely, key=lambda scored: scored.added not in forms):
        near = behind[scored.added] < share * gained or scored.added in forms
        if of_another_form and not near:
            near = excess(problem, scored) <= rules.left_share * excess(problem, without)
        elif near and not (of_another_form or unseen or scored.added in forms):
            most = rules.explained_error * problem.floor.total
            near = scored.fit.rmse <= most or not leaves_more_than_noise(problem, scored)
        if near and scored.possible and scored.added not in tied and is_free():
            tied.append(scored.added)
    return tuple(scored for scored in likely if scored.added in tied)


def _other_causes(problem: FitProblem, effect: str, names: Sequence[str]) -> set[str]:
    """Causes of these effects, other than that of `effect`: a class of them is one."""
    causes = {name: problem.classes[name].cause or name for name in [effect, *names]}
    return {causes[name] for name in names} - {causes[effect]}


def _up_to_form(problem: FitProblem, scored: Scored, without: Scored) -> bool:
    """Whether an effect, if no other came nearer, would explain up to the form of its equation."""
    most = problem.rules.left_share_always * excess(problem, without)
    return excess(problem, scored) <= most and not is_far(problem, scored)


def _as_good(problem: FitProblem, other: Scored, final: Scored) -> bool:
    """Whether another plausible model predicts held-out data within a standard error as well.

    Errors are weighed as the final model's fit weighs them, and differences are those of folds; as
    that looks at the likeliest parts of the error, the whole must not be larger either.
    """
    if has_few_folds(problem) or not other.plausible or lowers(problem, final, other):
        return False
    spectrum = problem.spectrum
    residuals = np.stack([other.held_out.residual, final.held_out.residual])
    weighed = spectrum.coefficients(residuals) ** 2 / final.fit.variance[spectrum.bands]
    table = problem.data.table
    more = np.bincount(table.fold, weighed[0] - weighed[1], len(table.folds))
    return bool(more.sum() < np.sqrt(len(more)) * np.std(more, ddof=1))


def null_maxima(signatures: Sequence[Signature], spectrum: Spectrum, seed: int) -> Array:
    """Largest falls of the deviance (draws,) over all candidates in sets of pure noise, sorted.

    In each draw, the noise level of each band is drawn too, as it is only known from that band's
    coefficients and the pseudo-observations of the floor. Each candidate is represented by its
    signatures, each scaled so that it gains most.
    """
    changes = [found.change[found.size > 0.0] for found in signatures]
    stacked = np.concatenate([change for change in changes if len(change)] or [np.zeros((0, 1))])
    if not len(stacked):
        return np.zeros(NOISE_DRAWS)
    stacked = stacked / np.linalg.norm(stacked, axis=1, keepdims=True)
    random = np.random.default_rng(seed)
    drawn = np.zeros((NOISE_DRAWS, len(stacked)))
    for band, count in enumerate(spectrum.counts()):
        root = stacked[:, spectrum.bands == band]
        if len(root) < root.shape[1]:
            level, vectors = np.linalg.eigh(root @ root.T)
            root = vectors * np.sqrt(np.maximum(level, 0.0))
        known = count + PSEUDO_OBSERVATIONS
        spread = np.sqrt(known / random.chisquare(known, NOISE_DRAWS))
        drawn += spread[:, None] * (random.standard_normal((NOISE_DRAWS, root.shape[1])) @ root.T)
    return np.sort(np.max(drawn**2, axis=1))


def p_value(maxima: Array, improvement: float) -> float:
    """Share of the sets of noise (`maxima`) in which some candidate gains as much as `improvement`;
    at least one over their number.
    """
    beyond = len(maxima) - int(np.searchsorted(maxima, improvement))
    return (beyond + 1) / (len(maxima) + 1)


def detectable_effects(problem: FitProblem, selection: Selection) -> list[Detectable]:
    """For each effect that could show, the weakest value of its first parameter that would have
    been detected.
    """
    found, size = [], problem.rules.detectable_share * problem.floor.total
    for scored in selection.singles:
        effect = problem.classes[scored.added]
        if effect.parameters and scored.signature is not None:
            smallest = _weakest(scored, selection.threshold, size)
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
    hidden = np.flatnonzero((strength > 0.0) & (strength < 1.0))
    if not len(hidden):
        return float(values[weakest])
    other = int(hidden[np.argmax(strength[hidden])])
    share = np.log(strength[weakest]) / np.log(strength[weakest] / strength[other])
    return float(values[weakest] + share * (values[other] - values[weakest]))


def _medians(values: Array) -> Array:
    """Middle trial value (k,) of each column, one of those that occur."""
    return np.array([np.unique(column)[len(np.unique(column)) // 2] for column in values.T])
