"""How the error fell, one effect after the other: by a whole explanation, or by part of one."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np

from model_lab.aliases import Array
from model_lab.diagnosis.errors import has_few_folds
from model_lab.diagnosis.growth import Growth
from model_lab.diagnosis.result import Step
from model_lab.diagnosis.search import Scored, score_with, score_without
from model_lab.fitting.problem import FitProblem

HALF = 0.5  # held-out error after an effect over the error before, at which it helps
MOST_FOLDS = 2 / 3  # in which it must do so
TOGETHER = 1 / 3  # the same of several effects that only together help much
MISSED = 1.25  # held-out error without one of these over the error with all
STANDARD_ERRORS = 3.0  # of the folds, by which one of these is missed


def story(problem: FitProblem, base: Scored, growth: Growth) -> tuple[Step, ...]:
    """How the held-out error fell from model to model, up to the chosen one."""
    return tuple(
        Step(
            " + ".join(name for name in after.effects if name not in before.effects),
            before.held_out.rmse,
            after.held_out.rmse,
        )
        for before, after in pairwise(path(problem, base, growth, growth.final))
    )


def path(problem: FitProblem, base: Scored, growth: Growth, final: Scored) -> tuple[Scored, ...]:
    """Models from the base to a larger one, with its effects one after the other.

    An effect that is seen only together with the next is left out on the way.
    """
    known = {frozenset(s.effects): s for models in growth.sizes for s in models}
    found = [base]
    for size in range(len(base.effects) + 1, len(final.effects)):
        effects = final.effects[:size]
        scored = known.get(frozenset(effects)) or score_with(problem, found[-1], effects[-1])
        if isinstance(scored, Scored):
            found.append(scored)
    return (*found, final)


def helping(problem: FitProblem, base: Scored, growth: Growth) -> tuple[Scored, ...]:
    """Models with the effects that, in this order, lower the held-out error though much is left.

    Each halves it or more, beyond chance and in most folds; or, where such effects do not take it
    to a third, several do together, and each of them is missed if it is left out.
    """
    halving = _halving(base, growth)
    if halving and halving[-1].held_out.rmse <= TOGETHER * base.held_out.rmse:
        return halving
    return _together(problem, base, growth) or halving


def _halving(base: Scored, growth: Growth) -> tuple[Scored, ...]:
    found, before = [], base
    for models in growth.sizes:
        better = [s for s in models if s.effects[:-1] == before.effects and _helps(s, before)]
        if not better:
            break
        before = better[0]
        found.append(before)
    return tuple(found)


def _helps(after: Scored, before: Scored) -> bool:
    """Whether an effect that is proven helps."""
    lower = after.held_out.mean_square < HALF**2 * before.held_out.mean_square
    most = bool(np.mean(lower) >= MOST_FOLDS)
    return most and after.held_out.rmse <= HALF * before.held_out.rmse


def _together(problem: FitProblem, base: Scored, growth: Growth) -> tuple[Scored, ...]:
    """Models on the way to the one of the least error, if it and all its effects are worth it."""
    several = [scored for models in growth.sizes[1:] for scored in models]
    if not several or has_few_folds(problem):
        return ()
    nearest = min(several, key=lambda scored: scored.held_out.rmse)
    final = _of_the_missed(problem, base, nearest)
    if final.held_out.rmse > TOGETHER * base.held_out.rmse:
        return ()
    found = path(problem, base, growth, final)
    each = len(found) == 1 + len(final.effects) - len(base.effects)
    falls = all(after.held_out.rmse < before.held_out.rmse for before, after in pairwise(found))
    return found[1:] if each and falls else ()


def _of_the_missed(problem: FitProblem, base: Scored, scored: Scored) -> Scored:
    """The same with those of its effects that are missed if they are left out, the most missed
    first; the least missed goes first, until each is.
    """
    added = [effect for effect in scored.effects if effect not in base.effects]
    fewer = {effect: score_without(problem, scored, effect) for effect in added}
    added.sort(key=lambda effect: -fewer[effect].held_out.rmse)
    least = fewer[added[-1]]
    if len(added) > 1 and not is_missed(scored.held_out.mean_square, least.held_out.mean_square):
        return _of_the_missed(problem, base, least)
    return replace(scored, effects=(*base.effects, *added))


def is_missed(there: Array, gone: Array) -> bool:
    """Whether an effect is missed, by mean squares of held-out errors (folds,) with it and without:
    beyond chance, in most folds and by much.
    """
    more = np.log(gone / there)
    beyond = np.mean(more) > STANDARD_ERRORS * np.std(more, ddof=1) / np.sqrt(len(more))
    most = np.mean(more > 0.0) >= MOST_FOLDS
    return bool(beyond and most and np.sum(gone) > MISSED**2 * np.sum(there))
