"""The verdict on a search, with the models it is about."""

from __future__ import annotations

from dataclasses import dataclass

from model_lab.diagnosis.black_boxes import BlackBox
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
    def leaves_much(self) -> bool:
        """Whether effects are named and the rest is worth reporting."""
        most = self.problem.rules.rest_error * self.problem.floor.total
        return bool(self.added) and self.named.held_out.rmse > most
