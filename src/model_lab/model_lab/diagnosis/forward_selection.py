"""Forward selection: effects are added one at a time, each with its own significance test.

From the best models of each size (a beam) the next larger ones are tried while much of the error is
left: of three equal effects the first two lower the error by a fifth and a sixth only. The larger
model must explain enough more than the smaller one; a backward pass drops effects that remove
little error in addition to the others.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace

from model_lab.diagnosis.criteria import (
    error_of,
    excess,
    has_few_folds,
    is_far,
    is_noise,
    lowers,
    material,
    share_left,
)
from model_lab.diagnosis.search import Scored, Unseen, score_without
from model_lab.fitting.held_out import hold_out
from model_lab.fitting.problem import INTERPOLATED, FitProblem, fitted_closer

Search = Callable[..., list[Scored | Unseen]]
"""`score_all` with the number of processes and a progress callback."""


@dataclass(frozen=True)
class ForwardSelection:
    """Models by their number of effects.

    sizes[n]: proven models with n + 1 effects more than the base, the best first. final: the chosen
    model; the base if none is chosen.
    """

    sizes: tuple[tuple[Scored, ...], ...]
    final: Scored


def criterion(scored: Scored) -> float:
    """Number by which models are compared, less is better: the deviance, a penalty for each
    parameter, and a penalty for unusual parameter values.
    """
    penalty = scored.rules.parameter_penalty * len(scored.fit.values)
    return scored.fit.deviance + penalty + scored.unusual


def proven(scored: Iterable[Scored], threshold: float) -> list[Scored]:
    """Models, best first, whose last effect lowers the deviance by more than `threshold` and whose
    parameters are plausible.
    """
    good = [s for s in scored if s.plausible and s.improvement > threshold]
    return sorted(good, key=criterion)


def select_forward(
    problem: FitProblem, base: Scored, singles: Sequence[Scored], threshold: float, search: Search
) -> ForwardSelection:
    """Add effects one at a time, and choose the model with those that are missing, at most four.

    singles: the base with one effect each. threshold: least fall of the deviance that counts.
    search: fits a model with each of some effects added.
    """
    good = proven(singles, threshold)
    if not good or not material(problem, base):
        return ForwardSelection((tuple(good),), base)
    nearest = _simulated_single(problem, base, good)
    if nearest is not good[0] and _explains_alone(problem, base, nearest):
        return ForwardSelection((tuple(good),), nearest)
    names = [s.added for s in singles]
    sizes = [good]
    while len(sizes) < problem.rules.most_effects and _is_open(problem, base, sizes):
        larger = _larger(problem, _firsts(base, sizes[-1]), names, threshold, search)
        if not larger:
            break
        sizes.append(larger)
    chosen = _chosen(problem, base, sizes, threshold, nearest)
    if not lowers(problem, chosen, base):
        return ForwardSelection(tuple(map(tuple, sizes)), base)
    return ForwardSelection(tuple(map(tuple, sizes)), with_own_held_out(problem, chosen))


def with_own_held_out(problem: FitProblem, scored: Scored) -> Scored:
    """The model with its held-out error computed by fits of their own for all folds, if folds are
    few: one step from the fit to all data would then be too inaccurate.
    """
    if not has_few_folds(problem):
        return scored
    fitted = scored.fit
    again = problem.once(
        lambda: hold_out(fitted, anew=True), "again", scored.effects, fitted.values.tobytes()
    )
    return replace(scored, held_out=again)


def closer(problem: FitProblem, scored: Scored) -> Scored:
    """The model, fitted and held out again by predictions that are closer near it."""
    again = fitted_closer(problem, scored.fit)
    if again is scored.fit:
        return scored
    return with_own_held_out(problem, replace(scored, fit=again, held_out=hold_out(again)))


def _simulated_single(problem: FitProblem, base: Scored, good: Sequence[Scored]) -> Scored:
    """The model with one effect that explains most: the best one, or where predictions are
    interpolated and it does not reach the floor, one of the best, simulated at its fitted values.
    """
    best, rules = good[0], problem.rules
    if problem.data.experiment not in INTERPOLATED or not material(problem, best):
        return best
    for single in good[: rules.simulated_singles]:
        if share_left(problem, single, base) <= rules.simulated_share:
            nearer = closer(problem, single)
            if nearer.plausible and error_of(problem, nearer) < error_of(problem, best):
                best = nearer
            if _explains_alone(problem, base, nearer):
                return nearer
    return best


def _explains_alone(problem: FitProblem, base: Scored, single: Scored) -> bool:
    """Whether a model with one effect leaves no more than noise, and explains most of the rest."""
    removed = share_left(problem, single, base) <= 1.0 - problem.rules.removed_share
    return (
        single.plausible and removed and is_noise(problem, single) and lowers(problem, single, base)
    )


def _is_open(problem: FitProblem, base: Scored, sizes: Sequence[Sequence[Scored]]) -> bool:
    """Whether what the best model of the largest size leaves is worth another effect."""
    best = sizes[-1][0]
    if not material(problem, best):
        return False
    rules = problem.rules
    most = {2: rules.third_effect_share, 3: rules.fourth_effect_share}
    if len(sizes) not in most:
        return True
    share = excess(problem, best) / excess(problem, base)
    much = share >= rules.many_each_share or is_far(problem, best)
    return much and share <= most[len(sizes)]


def _firsts(base: Scored, models: Sequence[Scored]) -> list[Scored]:
    """The models from which larger ones are tried: the best, and the one of the least error."""
    least = base.rules.beam_gain * (base.fit.deviance - models[0].fit.deviance)
    best = [s for s in models[: base.rules.beam] if base.fit.deviance - s.fit.deviance > least]
    nearest = min(models, key=lambda scored: scored.held_out.rmse)
    return best if any(s is nearest for s in best) else [*best, nearest]


def _larger(
    problem: FitProblem,
    firsts: Sequence[Scored],
    names: Sequence[str],
    threshold: float,
    search: Search,
) -> list[Scored]:
    """Plausible models of one effect more than `firsts`, the best first."""
    found: dict[frozenset[str], Scored] = {}
    for first in firsts:
        if found and not material(problem, min(found.values(), key=criterion)):
            break  # they reach the floor
        others = [name for name in names if name not in first.effects]
        tried = search(problem, first, others, limit=problem.rules.fitted_beside)
        for scored in proven((s for s in tried if isinstance(s, Scored)), threshold):
            known = found.setdefault(frozenset(scored.effects), scored)
            if criterion(scored) < criterion(known):
                found[frozenset(scored.effects)] = scored
    return sorted(found.values(), key=criterion)


def _chosen(
    problem: FitProblem,
    base: Scored,
    sizes: Sequence[Sequence[Scored]],
    threshold: float,
    single: Scored,
) -> Scored:
    """The best model of the largest size that is worth its last effect; the base if none is.

    single: the model with one effect that is to be chosen if none with more is.
    """
    for size in range(len(sizes) - 1, 0, -1):
        before = min((models[0] for models in sizes[:size]), key=criterion)
        hopeful = (_best(problem, sizes[size]), sizes[size][0])
        best = next((s for s in hopeful if _is_better(problem, s, before, threshold)), None)
        if best is None:
            continue
        kept = without_idle(problem, base, best)
        if size == 1 or (len(kept.effects) == len(best.effects) and _is_whole(problem, base, kept)):
            return kept
    most_left = 1.0 - problem.rules.removed_share
    return single if share_left(problem, single, base) <= most_left else base


def _best(problem: FitProblem, models: Sequence[Scored]) -> Scored:
    """The best of the models that reach the floor, or of all if none does.

    The likelihood depends mostly on shapes; an effect by which runs differ shows in the error.
    """
    near = problem.rules.explained_error * problem.floor.total
    return next((scored for scored in models if error_of(problem, scored) <= near), models[0])


def _is_better(problem: FitProblem, larger: Scored, smaller: Scored, threshold: float) -> bool:
    """Whether a model explains so much more than the best smaller one that it takes its effects."""
    gained = smaller.fit.deviance - larger.fit.deviance
    most_left = 1.0 - problem.rules.removed_share
    return gained > threshold and share_left(problem, larger, smaller) < most_left


def _is_whole(problem: FitProblem, base: Scored, scored: Scored) -> bool:
    """Whether three effects or more leave nearly nothing, and the error without each of them is a
    large share of the whole; or is far above the floor, while with all it is explained up to the
    form of an equation.
    """
    whole, left = excess(problem, base), excess(problem, scored)
    noise = is_noise(problem, scored)

    def is_missed(less: Scored) -> bool:
        rest = excess(problem, less)
        little = noise or left <= problem.rules.left_share * rest
        return rest > problem.rules.many_each_share * whole or (little and is_far(problem, less))

    added = (name for name in scored.effects if name not in base.effects)
    return all(is_missed(score_without(problem, scored, name)) for name in added)


def without_idle(problem: FitProblem, base: Scored, scored: Scored) -> Scored:
    """The model without effects that remove little error in addition to the others. They are
    dropped one at a time, first the one that removes least.
    """
    added = [effect for effect in scored.effects if effect not in base.effects]
    if len(added) < 2:
        return scored
    fewer = [score_without(problem, scored, effect) for effect in added]
    shares = [share_left(problem, scored, smaller) for smaller in fewer]
    idlest = max(range(len(fewer)), key=shares.__getitem__)
    if shares[idlest] <= 1.0 - problem.rules.removed_share:
        return scored
    return without_idle(problem, base, fewer[idlest])
