"""How the error fell, one effect after the other: by a whole explanation, or by part of one."""

from __future__ import annotations

import numpy as np

from model_lab.diagnosis.growth import Growth
from model_lab.diagnosis.search import Scored, score_with
from model_lab.fitting.problem import FitProblem

HALF = 0.5  # held-out error after an effect over the error before, at which it helps
MOST_FOLDS = 2 / 3  # in which it must do so


def path(problem: FitProblem, base: Scored, growth: Growth) -> tuple[Scored, ...]:
    """Models from the base to the final one, with the missing effects one after the other.

    An effect that is seen only together with the next is left out on the way.
    """
    known = {frozenset(s.effects): s for models in growth.sizes for s in models}
    found = [base]
    for size in range(len(base.effects) + 1, len(growth.final.effects)):
        effects = growth.final.effects[:size]
        scored = known.get(frozenset(effects)) or score_with(problem, found[-1], effects[-1])
        if isinstance(scored, Scored):
            found.append(scored)
    return (*found, growth.final)


def helping(base: Scored, growth: Growth) -> tuple[Scored, ...]:
    """Models with the effects that, in this order, each lower the held-out error by half or more
    beyond chance and in most folds, though much is left.
    """
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
