"""Growth of a model by what it lacks: effects one after the other, each proven on its own.

From the best models of each size the next larger ones are tried, as long as much is left: of three
effects of equal size the first two lower the error by a fifth and a sixth only. What a size larger
brings must be worth it, and what removes little beside the others is dropped again.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace

from model_lab.diagnosis.errors import (
    NEAR_FLOOR,
    OF_ANOTHER_FORM,
    REMOVED,
    STILL_NEAR,
    error_of,
    excess,
    has_few_folds,
    is_noise,
    lowers,
    material,
    share_left,
)
from model_lab.diagnosis.search import Scored, Unseen, score_without
from model_lab.fitting.held_out import hold_out
from model_lab.fitting.problem import FitProblem

Search = Callable[..., list[Scored | Unseen]]
"""`score_all` with the processes to use, and whom to tell."""

MOST_EFFECTS = 4
PARAMETER_PENALTY = 3.0  # deviance that a parameter must bring when effects compete
BEAM = 3  # models of each size from which larger ones are tried
WORTHWHILE = 0.2  # of the largest improvement, that such a model must bring
FITTED = 5  # effects that are fitted beside each of them
HOPEFUL = {2: 0.9, 3: 0.75}  # share of the excess error at which so many effects get one more
NEARLY_NOTHING = 0.15  # of the excess error of the base, that more than two effects may leave
SUBSTANTIAL = 0.25  # of the excess error of the base, that more than two effects must be about


@dataclass(frozen=True)
class Growth:
    """Models by size: sizes[n] has the proven ones with n + 1 effects more than the base, the best
    first. final: the chosen one, the base if none.
    """

    sizes: tuple[tuple[Scored, ...], ...]
    final: Scored


def criterion(scored: Scored) -> float:
    """Deviance of a model, what its parameters must bring, and how unusual they are."""
    return scored.fit.deviance + PARAMETER_PENALTY * len(scored.fit.values) + scored.unusual


def proven(scored: Iterable[Scored], threshold: float) -> list[Scored]:
    """Plausible models whose last effect brings more than mere noise does, the best first."""
    good = [s for s in scored if s.plausible and s.improvement > threshold]
    return sorted(good, key=criterion)


def grow(
    problem: FitProblem, base: Scored, singles: Sequence[Scored], threshold: float, search: Search
) -> Growth:
    """The model with the effects that are missing, up to four."""
    good = proven(singles, threshold)
    if not good or not material(problem, base):
        return Growth((tuple(good),), base)
    names = [s.added for s in singles]
    sizes = [good]
    while len(sizes) < MOST_EFFECTS and _is_open(problem, base, sizes):
        larger = _larger(problem, _firsts(base, sizes[-1]), names, threshold, search)
        if not larger:
            break
        sizes.append(larger)
    chosen = _chosen(problem, base, sizes, threshold)
    if not lowers(problem, chosen, base):
        return Growth(tuple(map(tuple, sizes)), base)
    if has_few_folds(problem):  # which by a step from the fit of all are predicted too badly
        chosen = replace(chosen, held_out=hold_out(chosen.fit, anew=True))
    return Growth(tuple(map(tuple, sizes)), chosen)


def _is_open(problem: FitProblem, base: Scored, sizes: Sequence[Sequence[Scored]]) -> bool:
    """Whether what the best model of the largest size leaves is worth another effect."""
    best = sizes[-1][0]
    if not material(problem, best):
        return False
    if len(sizes) not in HOPEFUL:
        return True
    share = excess(problem, best) / excess(problem, base)
    much = share >= SUBSTANTIAL or _is_far(problem, best)
    return much and share <= HOPEFUL[len(sizes)]


def _is_far(problem: FitProblem, scored: Scored) -> bool:
    """Whether a model's error is so far above the floor that it explains nothing by itself."""
    return error_of(problem, scored) > STILL_NEAR * problem.floor.total


def _firsts(base: Scored, models: Sequence[Scored]) -> list[Scored]:
    """The models from which larger ones are tried: the best, and the one of the least error."""
    least = WORTHWHILE * (base.fit.deviance - models[0].fit.deviance)
    best = [s for s in models[:BEAM] if base.fit.deviance - s.fit.deviance > least]
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
        tried = search(problem, first, others, limit=FITTED)
        for scored in proven((s for s in tried if isinstance(s, Scored)), threshold):
            known = found.setdefault(frozenset(scored.effects), scored)
            if criterion(scored) < criterion(known):
                found[frozenset(scored.effects)] = scored
    return sorted(found.values(), key=criterion)


def _chosen(
    problem: FitProblem, base: Scored, sizes: Sequence[Sequence[Scored]], threshold: float
) -> Scored:
    """The best model of the largest size that is worth its last effect; the base if none is."""
    for size in range(len(sizes) - 1, 0, -1):
        before = min((models[0] for models in sizes[:size]), key=criterion)
        hopeful = (_best(problem, sizes[size]), sizes[size][0])
        best = next((s for s in hopeful if _is_better(problem, s, before, threshold)), None)
        if best is None:
            continue
        kept = without_idle(problem, base, best)
        if size == 1 or (len(kept.effects) == len(best.effects) and _is_whole(problem, base, kept)):
            return kept
    single = sizes[0][0]
    return single if share_left(problem, single, base) <= 1.0 - REMOVED else base


def _best(problem: FitProblem, models: Sequence[Scored]) -> Scored:
    """The best of the models that reach the floor, or of all if none does.

    Likelihood hangs on shapes; an effect that tells runs apart shows in the error.
    """
    near = NEAR_FLOOR * problem.floor.total
    return next((scored for scored in models if error_of(problem, scored) <= near), models[0])


def _is_better(problem: FitProblem, larger: Scored, smaller: Scored, threshold: float) -> bool:
    """Whether a model explains so much more than the best smaller one that it takes its effects."""
    gained = smaller.fit.deviance - larger.fit.deviance
    return gained > threshold and share_left(problem, larger, smaller) < 1.0 - REMOVED


def _is_whole(problem: FitProblem, base: Scored, scored: Scored) -> bool:
    """Whether more than two effects leave nearly nothing, and each is about much of the error; or
    about what is far above the floor, of which they leave as little as another form would.
    """
    whole, left = excess(problem, base), excess(problem, scored)
    noise = is_noise(problem, scored)
    if not noise and left > NEARLY_NOTHING * whole:
        return False

    def is_missed(less: Scored) -> bool:
        rest = excess(problem, less)
        little = noise or left <= OF_ANOTHER_FORM * rest
        return rest > SUBSTANTIAL * whole or (little and _is_far(problem, less))

    added = (name for name in scored.effects if name not in base.effects)
    return all(is_missed(score_without(problem, scored, name)) for name in added)


def without_idle(problem: FitProblem, base: Scored, scored: Scored) -> Scored:
    """The same without effects that, once the others are there, remove little: one pass backwards.

    The idlest goes first.
    """
    added = [effect for effect in scored.effects if effect not in base.effects]
    if len(added) < 2:
        return scored
    fewer = [score_without(problem, scored, effect) for effect in added]
    shares = [share_left(problem, scored, smaller) for smaller in fewer]
    idlest = max(range(len(fewer)), key=shares.__getitem__)
    if shares[idlest] <= 1.0 - REMOVED:
        return scored
    return without_idle(problem, base, fewer[idlest])
