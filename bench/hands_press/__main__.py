"""Hidden effects of pressed hands: `python -m bench.hands_press [NUMBERS]` makes the sets in
MuJoCo, diagnoses them, and prints Markdown.

Criteria, fixed before the first run: a set is *right* if the verdict is effects_missing with one
effect, the hidden one at its place; *tied* if the hidden one is among what is tied with it; else
*wrong* if something is named. Nothing hidden must be adequate, what is outside of the catalogue
unexplained; of a force sensor that was tared with bent fingers, the slip. With samples shuffled,
nothing must be named, and the model must not be adequate. Of a right one with a single parameter,
the 95 % interval must hold the hidden value. The lab searches its whole catalogue.
"""

from __future__ import annotations

import numpy as np

from bench.command_line import chosen_cases
from bench.hands.cases import Hidden
from bench.hands.verdicts import judge
from bench.hands_press.cases import PLAN, SEED, hidden_in
from bench.hands_press.measure import measured
from model_lab.measurements.measurement_set import MeasurementSet
from softhand_model.hand.hand import load_hand


def main() -> None:
    """Run the whole plan, or the cases of the numbers given, and print a row for each and sums."""
    numbers = chosen_cases("bench.hands_press", __doc__, len(PLAN))
    judge("hands_press", numbers, _case, "mN")


def _case(number: int) -> tuple[Hidden, MeasurementSet]:
    random = np.random.default_rng(SEED + number)
    hidden = hidden_in(load_hand("rbo_hand_2"), *PLAN[number], random)
    return hidden, measured(hidden, random)


if __name__ == "__main__":
    main()
