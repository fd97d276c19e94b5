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

    named: the model with the named effects, the base if none. helping: models with the effects that
    help in part, where nothing explains the error. black_boxes: fitted to what the final model of
    the search leaves, the best first.
    """

    problem: FitProblem
    selection: Selection
    black_boxes: tuple[BlackBox, ...]
    verdict: str
    named: Scored
    helping: tuple[Scored, ...]

    @property
    def added(self) -> list[str]:
        """The named effects."""
        return [name for name in self.named.effects if name not in self.selection.base.effects]

    @property
    def at_bound(self) -> bool:
        """Whether effects are named and the calibration stays on a bound beside them."""
        return bool(self.added and calibration_at_bound(self.named))

    @property
    def most_confidence(self) -> float:
        """The largest confidence that what the named model leaves allows, with a calibration on its
        bound or without.
        """
        rules, left = self.problem.rules, self.named.held_out.rmse / self.problem.floor.total
        if self.at_bound and left > rules.bound_error:
            return rules.bound_confidence
        return rules.rest_confidence if self.leaves_much else 1.0

    @property
    def leaves_much(self) -> bool:
        """Whether effects are named and the rest is worth reporting."""
        most = self.problem.rules.rest_error * self.problem.floor.total
        return bool(self.added) and self.named.held_out.rmse > most
