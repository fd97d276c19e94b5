"""The verdict on a search, with the models it is about."""

from __future__ import annotations

from dataclasses import dataclass

from model_lab.diagnosis.black_boxes import BlackBox
from model_lab.diagnosis.result import calibration_at_bound
from model_lab.diagnosis.search import Scored
from model_lab.diagnosis.selection import Selection
from model_lab.fitting.problem import FitProblem


@dataclass(frozen=True)
class Judgement:
    """The verdict on a search, and the models it is about.

    named: the model with the effects that the verdict names; the base if it names none. helping:
    models with effects that explain a part, if nothing explains the whole error. greater: models
    with one effect that explain the greater part, if none helps. black_boxes: fitted to what the
    final model of the search leaves, the best first.
    """

    problem: FitProblem
    selection: Selection
    black_boxes: tuple[BlackBox, ...]
    verdict: str
    named: Scored
    helping: tuple[Scored, ...]
    greater: tuple[Scored, ...] = ()

    @property
    def added(self) -> list[str]:
        """Names of the effects that the verdict names."""
        return [name for name in self.named.effects if name not in self.selection.base.effects]

    @property
    def at_bound(self) -> bool:
        """Whether effects are named and, with them in the model, a parameter of the calibration
        lies on a bound.
        """
        return bool(self.added and calibration_at_bound(self.named))

    @property
    def most_confidence(self) -> float:
        """Highest confidence (0 to 1) that a diagnosis may state. It is below 1 if much error
        remains, and also for a smaller remaining error (`Rules.bound_error`) if a parameter of the
        calibration lies on its bound.
        """
        rules, left = self.problem.rules, self.named.held_out.rmse / self.problem.floor.total
        if self.at_bound and left > rules.bound_error:
            return rules.bound_confidence
        return rules.rest_confidence if self.leaves_much else 1.0

    @property
    def leaves_much(self) -> bool:
        """Whether effects are named, and the remaining error is large enough to be reported."""
        most = self.problem.rules.rest_error * self.problem.floor.total
        return bool(self.added) and self.named.held_out.rmse > most
