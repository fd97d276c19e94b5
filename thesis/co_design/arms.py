"""The arms: which numbers are free, by which sampler, and whether the search sees true scores."""

from __future__ import annotations

from dataclasses import dataclass

from grasp_strategies.search import Variable
from thesis.co_design import hands, motions

BOTH = (*hands.VARIABLES, *motions.VARIABLES)


@dataclass(frozen=True)
class Arm:
    """A way to search.

    `sampler`: of the searches. CMA-ES about the shipped pair was chosen before any run, on a
    made-up problem of 18 numbers with 22 generations: true success of what two seeds ended with was
    0.81 and 0.81 from 0.54, of CMA-ES about the middle of the ranges 0.79 and 0.48, of TPE 0.54 and
    0.70. `labels`: what the search is told: `true` scores, those of a generation `shuffled`, or
    `noise`.
    """

    name: str
    variables: tuple[Variable, ...]
    sampler: str = "cma"
    labels: str = "true"

    @property
    def free_hand(self) -> bool:
        """Whether the hand varies."""
        return bool(set(self.variables) & set(hands.VARIABLES))


CO_DESIGN = Arm("co-design", BOTH)
SINGLE = (Arm("motion", motions.VARIABLES), Arm("hand", hands.VARIABLES))
RANDOM = Arm("random", BOTH, "random")
ARMS = (CO_DESIGN, *SINGLE, RANDOM)  # with equal numbers of trials
SHUFFLED = Arm("shuffled", BOTH, labels="shuffled")
NOISE = Arm("noise", BOTH, labels="noise")
