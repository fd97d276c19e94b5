"""Adding an effect: fit the model with it and return the model that the file will hold."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from model_lab.candidates import inapplicable, invisible, signature, with_trials
from model_lab.diagnosis import NamedEffect
from model_lab.estimates import calibration_of, named_effect
from model_lab.fit import Problem, fit
from model_lab.holdout import hold_out
from model_lab.measurement import MeasurementSet
from model_lab.question import Question, pose_question, sharper
from model_lab.search import Scored, Unseen, score_base, score_with
from softhand_model.effects import Effect
from softhand_model.model_file import Model


@dataclass(frozen=True)
class Addition:
    """A model with one effect more: before and after as fitted, and as a file holds it."""

    question: Question
    before: Scored
    after: Scored
    effect: NamedEffect
    model: Model


def add_effect(
    name: str, data: MeasurementSet, model: Model, classes: Mapping[str, type[Effect]]
) -> Addition:
    """Fit calibration, the effects that were fitted before, and the new one, all together.

    Raises ValueError when the effect is unknown, already there, or cannot be seen in the data.
    """
    if name not in classes:
        raise ValueError(f"effect: expected one of {', '.join(sorted(classes))}, got {name}")
    if any(effect.name == name for effect in model.effects):
        raise ValueError(f"effect: expected one that the model does not have yet, got {name}")
    reason = inapplicable(classes[name], data, model.base)
    if reason is not None:
        raise ValueError(f"effect {name}: expected one that these data show, but: {reason}")
    question, given = pose_question(data, model, classes)
    question, before, after = _before_and_after(question, [effect.name for effect in given], name)
    named = [named_effect(after, effect) for effect in after.effects]
    kept = tuple(effect for effect in model.effects if effect.name not in after.effects)
    fitted = tuple(_instance(question, entry) for entry in named)
    std = {
        entry.name: {key: estimate.std for key, estimate in entry.parameters.items()}
        for entry in named
        if question.classes[entry.name].physical  # a generic term stays as it is from now on
    }
    new = Model(model.base, calibration_of(after), (*kept, *fitted), std, springs=model.springs)
    return Addition(question, before, after, named[-1], new)


def _before_and_after(
    question: Question, given: Sequence[str], name: str
) -> tuple[Question, Scored, Scored]:
    """The model without and with an effect; the question with the floor that is then seen.

    Raises ValueError when the data do not show the effect.
    """
    before = score_base(question, given)
    after = _scored(question, before, name)
    if isinstance(after, Unseen):
        raise ValueError(f"effect {name}: expected one that these data show, but: {after.reason}")
    clearer = sharper(question, after.fit)
    return (question, before, after) if clearer is None else _before_and_after(clearer, given, name)


def _scored(question: Question, before: Scored, name: str) -> Scored | Unseen:
    """The model with one effect more."""
    if question.classes[name].physical:
        return score_with(question, before, name)
    return _with_generic_term(question, before, name)


def _with_generic_term(question: Question, before: Scored, name: str) -> Scored | Unseen:
    """The model with a generic term, fitted by least squares: it has to take off as much of the
    error as it can, not to explain it. What the data do not show of it stays where it does nothing.
    """
    effect = question.classes[name]
    problem = question.problem((*before.effects, name))
    seen = signature(problem, before.fit, effect)
    reason = invisible(seen, question.floor.total)
    if reason is not None:
        return Unseen(name, reason)
    idle = np.array([[parameter.neutral or 0.0 for parameter in effect.parameters]])
    spectrum = question.spectrum.in_one_band()
    white = np.full(spectrum.band_count, question.floor.total**2)
    squares = Problem(problem.forward, spectrum, white)
    after = fit(squares, with_trials(squares, before.fit, name, idle))
    return Scored((*before.effects, name), after, hold_out(after), signature=seen)


def _instance(question: Question, named: NamedEffect) -> Effect:
    values = {key: estimate.value for key, estimate in named.parameters.items()}
    return question.classes[named.name](**values)
