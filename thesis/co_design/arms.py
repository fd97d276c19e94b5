"""The arms of the comparison: which numbers are free, which sampler is used, and which scores it
gets.
"""

from __future__ import annotations

from dataclasses import dataclass

from softhand_trials.search import Variable
from thesis.co_design import hands, motions

BOTH = (*hands.VARIABLES, *motions.VARIABLES)


@dataclass(frozen=True)
class Arm:
    """A way to search.

    `sampler`: CMA-ES about the shipped pair was chosen before any run, on a synthetic problem of 18
    numbers with 22 generations: the true success of the results of two seeds rose from 0.54 to 0.81
    and 0.81; of CMA-ES about the middle of the ranges it was 0.79 and 0.48, of TPE 0.54 and 0.70.
    `labels`: the scores that the search gets: `true` ones, those of a generation `shuffled`, or
    `noise`.
    """

    name: str
    variables: tuple[Variable, ...]
    sampler: str = "cma"
    labels: str = "true"

    @property
    def free_hand(self) -> bool:
        """Whether the search varies the hand."""
        return bool(set(self.variables) & set(hands.VARIABLES))


CO_DESIGN = Arm("co-design", BOTH)
SINGLE = (Arm("motion", motions.VARIABLES), Arm("hand", hands.VARIABLES))
RANDOM = Arm("random", BOTH, "random")
ARMS = (CO_DESIGN, *SINGLE, RANDOM)  # with equal numbers of trials
SHUFFLED = Arm("shuffled", BOTH, labels="shuffled")
NOISE = Arm("noise", BOTH, labels="noise")
