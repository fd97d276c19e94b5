"""First look at a set, before the search: the error, and the most promising effects.

Each effect is represented by its signatures, scaled at best (`search.promise`): nothing is fitted
but the model as it is. The search that follows may come to another answer.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from model_lab.diagnosis.criteria import is_noise
from model_lab.diagnosis.search import Scored, invisible, promise, signature_of
from model_lab.fitting.problem import FitProblem
from model_lab.rules import RULES
from model_lab.slips.slip import Slip

LIKELIEST = 3  # effects that are told


@dataclass(frozen=True)
class FirstLook:
    """Results that are known before the search.

    rmse, noise_floor: held-out error and noise floor, in `unit` (SI). slips: mistakes in how the
    data are stated. likeliest: (name, share of the mean square error that it may explain alone) of
    effects, the likeliest first. is_noise: whether the error may be noise alone.
    """

    rmse: float
    noise_floor: float
    unit: str
    is_noise: bool
    slips: tuple[Slip, ...]
    likeliest: tuple[tuple[str, float], ...]


TellFirst = Callable[[FirstLook], None]


def tell_no_first(_found: FirstLook) -> None:
    """A callback that does nothing."""


def first_look(
    problem: FitProblem, base: Scored, effects: Sequence[str], slips: Sequence[Slip]
) -> FirstLook:
    """The first look at a problem whose base is fitted; effects: names of those that could be
    missing.
    """
    promised = {}
    for name in effects:
        found = signature_of(problem, base, name)
        if invisible(found, problem.floor.total, problem.rules) is None:
            fall, share = promise(found, base.fit)
            cost = problem.rules.parameter_penalty * len(problem.classes[name].parameters)
            if fall - cost > RULES.first_look_fall:
                promised[name] = fall - cost, share
    ranked = sorted(promised, key=lambda name: -promised[name][0])
    shares = [(name, float(np.clip(promised[name][1], 0.0, 1.0))) for name in ranked[:LIKELIEST]]
    return FirstLook(
        base.held_out.rmse,
        problem.floor.total,
        problem.data.unit,
        is_noise(problem, base),
        tuple(slips),
        tuple(shares),
    )
