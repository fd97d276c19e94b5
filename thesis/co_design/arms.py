"""The arms: which numbers are free, by which sampler, and whether the search sees true scores."""

from __future__ import annotations

from dataclasses import dataclass

from grasp_strategies.search import Variable
from thesis.co_design import hands, motions

BOTH = (*hands.VARIABLES, *motions.VARIABLES)


@dataclass(frozen=True)
class Arm:
    """A way to search.

    `sampler`: of the searches. CMA-ES was chosen before any run, on a made-up problem of 18 numbers
    with this budget, where TPE, told scores of two trials, found no more than chance. `labels`:
    what the search is told: `true` scores, those of a generation `shuffled`, or `noise`.
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
