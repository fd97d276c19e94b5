"""How the error falls with each effect that is added, for a whole or a partial explanation."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise

import numpy as np

from model_lab.aliases import Array
from model_lab.diagnosis.criteria import has_few_folds
from model_lab.diagnosis.forward_selection import ForwardSelection
from model_lab.diagnosis.result import Step
from model_lab.diagnosis.search import Scored, score_with, score_without
from model_lab.fitting.problem import FitProblem
from model_lab.rules import RULES, Rules


def error_by_step(problem: FitProblem, base: Scored, forward: ForwardSelection) -> tuple[Step, ...]:
    """How much each added effect lowered the held-out error, from the base to the chosen model."""
    return tuple(
        Step(
            " + ".join(name for name in after.effects if name not in before.effects),
            before.held_out.rmse,
            after.held_out.rmse,
        )
        for before, after in pairwise(path(problem, base, forward, forward.final))
    )


def path(
    problem: FitProblem, base: Scored, forward: ForwardSelection, final: Scored
) -> tuple[Scored, ...]:
    """Fitted models from the base to `final`, to which the effects of `final` are added one after
    the other.

    There is no model for an effect that shows only together with the next one.
    """
    known = {frozenset(s.effects): s for models in forward.sizes for s in models}
    found = [base]
    for size in range(len(base.effects) + 1, len(final.effects)):
        effects = final.effects[:size]
        scored = known.get(frozenset(effects)) or score_with(problem, found[-1], effects[-1])
        if isinstance(scored, Scored):
            found.append(replace(scored, effects=effects))  # in the order in which they are told
    return (*found, final)


def helping(problem: FitProblem, base: Scored, forward: ForwardSelection) -> tuple[Scored, ...]:
    """Fitted models to which effects are added one after the other that lower the held-out error
    but leave much of it; empty if none do.

    Either each effect halves the error or more; or, if such effects leave more than a third,
    several together bring it below a third, and each of them is missed if it is left out.
    """
    halving = _halving(base, forward)
    if halving and halving[-1].held_out.rmse <= problem.rules.together_error * base.held_out.rmse:
        return halving
    return _together(problem, base, forward) or halving


def greater_part(problem: FitProblem, base: Scored, proven: Sequence[Scored]) -> tuple[Scored, ...]:
    """Models with one effect that remove the greater part of the held-out mean square error above
    the floor (`Rules.greater_part`), the best first; empty if none does, or if so many do
    (`Rules.most_unusual_ties`) that the data cannot tell which.

    proven: models with one effect each, the best first.
    """
    rules = problem.rules
    found = [one for one in proven if share_removed(problem, one, base) > rules.greater_part]
    if not found:
        return ()
    largest = rules.material_error * found[0].held_out.rmse
    alike = [one for one in found if one.held_out.rmse <= largest]
    causes = {problem.classes[one.added].cause or one.added for one in alike}
    return tuple(alike) if len(causes) <= 1 + rules.most_unusual_ties else ()


def share_removed(problem: FitProblem, after: Scored, before: Scored) -> float:
    """Share of the held-out mean square error above the floor that the model `after` removes; 0
    where the model `before` leaves none.
    """
    fall = before.held_out.rmse**2 - after.held_out.rmse**2
    whole = before.held_out.rmse**2 - problem.floor.total**2
    return min(fall / whole, 1.0) if whole > 0.0 else 0.0


def _halving(base: Scored, forward: ForwardSelection) -> tuple[Scored, ...]:
    found, before = [], base
    for models in forward.sizes:
        better = [s for s in models if s.effects[:-1] == before.effects and _helps(s, before)]
        if not better:
            break
        before = better[0]
        found.append(before)
    return tuple(found)


def _helps(after: Scored, before: Scored) -> bool:
    """Whether an effect that is proven helps."""
    return after.held_out.rmse <= after.rules.help_error * before.held_out.rmse


def _together(problem: FitProblem, base: Scored, forward: ForwardSelection) -> tuple[Scored, ...]:
    """Models on the way to the one of the least error, if it and all its effects are worth it."""
    several = [scored for models in forward.sizes[1:] for scored in models]
    if not several or has_few_folds(problem):
        return ()
    nearest = min(several, key=lambda scored: scored.held_out.rmse)
    final = _of_the_missed(problem, base, nearest)
    if final.held_out.rmse > problem.rules.together_error * base.held_out.rmse:
        return ()
    found = path(problem, base, forward, final)
    each = len(found) == 1 + len(final.effects) - len(base.effects)
    falls = all(after.held_out.rmse < before.held_out.rmse for before, after in pairwise(found))
    return found[1:] if each and falls else ()


def _of_the_missed(problem: FitProblem, base: Scored, scored: Scored) -> Scored:
    """The same model without effects whose removal hardly raises the error; the one that matters
    least is dropped first, until all matter. Effects are sorted by how much they matter.
    """
    added = [effect for effect in scored.effects if effect not in base.effects]
    fewer = {effect: score_without(problem, scored, effect) for effect in added}
    added.sort(key=lambda effect: -fewer[effect].held_out.rmse)
    least = fewer[added[-1]]
    errors = scored.held_out.mean_square, least.held_out.mean_square
    if len(added) > 1 and not is_missed(*errors, problem.rules):
        return _of_the_missed(problem, base, least)
    return replace(scored, effects=(*base.effects, *added))


def is_missed(there: Array, gone: Array, rules: Rules = RULES) -> bool:
    """Whether an effect is missed: without it the mean logarithm of the mean square held-out errors
    is larger, and their sum is larger by much (`Rules.missed_error`).

    there, gone: mean square held-out errors (folds,) with and without the effect.
    """
    more = np.mean(np.log(gone / there)) > 0.0
    return bool(more and np.sum(gone) > rules.missed_error**2 * np.sum(there))
