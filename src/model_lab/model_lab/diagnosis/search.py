"""The search for missing effects: fit, add, compare, with every model judged on held-out data."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from multiprocessing import get_context

import numpy as np
from numpy.typing import NDArray

from model_lab.diagnosis.candidates import (
    Signature,
    invisible,
    names,
    promised_improvement,
    signature,
    starts,
    with_trials,
)
from model_lab.fitting.fit import Fit, fit
from model_lab.fitting.problem import HeldOut, Question, base_starts, hold_out
from softhand_model.effects import Effect

Array = NDArray[np.float64]

KNOWN, KNOWN_FACTOR = 0.6, 0.8  # standard error over a value, or of its logarithm


@dataclass(frozen=True)
class Scored:
    """A fitted model with what it says of held-out data.

    known: whether every effect has a parameter that the data tell. improvement: fall of the
    deviance against the model it came from. signature: of the effect that was added last.
    """

    effects: tuple[str, ...]
    fit: Fit
    held_out: HeldOut
    known: bool = True
    improvement: float = 0.0
    signature: Signature | None = None

    @property
    def added(self) -> str:
        """The effect that was added last."""
        return self.effects[-1]

    @property
    def plausible(self) -> bool:
        """Whether the parameters of its effects are off their limits, and known at all."""
        parameters = self.fit.problem.forward.parameters
        if any(p.effect and limit for p, limit in zip(parameters, self.fit.at_limit, strict=True)):
            return False
        return self.known

    def parameters_of(self, effect: str) -> list[int]:
        """Indices of an effect's parameters."""
        parameters = self.fit.problem.forward.parameters
        return [index for index, p in enumerate(parameters) if p.effect == effect]


@dataclass(frozen=True)
class Unseen:
    """An effect that cannot be seen in a set beside the model it was tried with, and why."""

    name: str
    reason: str


def score_base(
    question: Question, effects: Sequence[str] = (), start: Array | None = None
) -> Scored:
    """The model with some effects, fitted from a start (k,) or from what is known of it."""
    problem = question.problem(effects)
    parameters = problem.forward.parameters
    if start is None and all(p.name in question.fitted for p in parameters):
        start = np.array([question.fitted[p.name] for p in parameters], float)
    found = fit(problem, base_starts(parameters) if start is None else start[None])
    return Scored(tuple(effects), found, hold_out(found))


def score_with(question: Question, before: Scored, effect: str) -> Scored | Unseen:
    """The model with one effect more."""
    effects = (*before.effects, effect)
    problem = question.problem(effects)
    found = signature(problem, before.fit, question.classes[effect])
    reason = invisible(found, question.floor.total)
    if reason is not None:
        return Unseen(effect, reason)
    first = with_trials(problem, before.fit, effect, starts(found, before.fit))
    after = fit(problem, first)
    gained = before.fit.deviance - after.deviance
    known = before.known and is_known(after, question.classes[effect])
    return Scored(effects, after, hold_out(after), known, gained, found)


def is_known(fit: Fit, effect: type[Effect]) -> bool:
    """Whether any parameter of an effect is known: its standard error tells it from no effect.

    Where none is, a term grows without bound against another, and stands for neither.
    """
    scales, spread = fit.problem.scales, np.sqrt(np.diag(fit.covariance))
    place = {
        parameter.name: index for index, parameter in enumerate(fit.problem.forward.parameters)
    }
    for parameter in effect.parameters:
        index = place[f"{effect.name}.{parameter.name}"]
        distance = abs(fit.values[index] - (parameter.neutral or 0.0))
        allowed = KNOWN_FACTOR if scales.logarithmic[index] else KNOWN * distance
        if spread[index] < allowed:
            return True
    return not effect.parameters


def score_without(question: Question, before: Scored, effect: str) -> Scored:
    """The model with one effect less."""
    kept = tuple(name for name in before.effects if name != effect)
    problem = question.problem(kept)
    values = dict(zip(names(before.fit.problem), before.fit.values, strict=True))
    start = np.array([values.get(p.name, p.start) for p in problem.forward.parameters])
    return score_base(question, kept, start)


def score_all(
    question: Question, before: Scored, effects: Sequence[str], jobs: int = 1, limit: int = 0
) -> list[Scored | Unseen]:
    """The model with each of the effects added in turn, by so many processes.

    With a limit only so many effects are fitted: those whose signatures promise most.
    """
    if limit and len(effects) > limit:
        effects = _most_promising(question, before, effects, limit)
    if jobs < 2 or len(effects) < 2:
        return [score_with(question, before, effect) for effect in effects]
    return _in_processes(question, before, effects, jobs)


def _most_promising(
    question: Question, before: Scored, effects: Sequence[str], limit: int
) -> list[str]:
    promise = {}
    for effect in effects:
        problem = question.problem((*before.effects, effect))
        found = signature(problem, before.fit, question.classes[effect])
        promise[effect] = promised_improvement(found, before.fit)
    return sorted(effects, key=lambda effect: -promise[effect])[:limit]


_task: tuple[Question, Scored] | None = None  # inherited by forked processes, never changed in them


def _in_processes(
    question: Question, before: Scored, effects: Sequence[str], jobs: int
) -> list[Scored | Unseen]:
    """As `score_all`; results come back without their problem, which the parent knows."""
    global _task
    _task = (question, before)
    with get_context("fork").Pool(jobs) as pool:
        results = pool.map(_work, effects, chunksize=1)
    _task = None
    return [
        result
        if isinstance(result, Unseen)
        else replace(result, fit=replace(result.fit, problem=question.problem(result.effects)))
        for result in results
    ]


def _work(effect: str) -> Scored | Unseen:
    if _task is None:
        raise RuntimeError("a process of the search was started without its task")
    result = score_with(*_task, effect)
    if isinstance(result, Unseen):
        return result
    # the problem holds classes of a user's file, which no other process can read
    return replace(result, fit=replace(result.fit, problem=None))  # type: ignore[arg-type]
