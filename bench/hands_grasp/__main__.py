"""Hidden effects of hands that grasp: `python -m bench.hands_grasp [NUMBERS]` makes the sets in
MuJoCo, or in PyBullet with other segments and steps, diagnoses them, and prints Markdown.

Criteria, fixed before the first run: a set is *right* if the verdict is effects_missing with one
effect, the hidden one at its place; *tied* if the hidden one is among what is tied with it; else
*wrong* if something is named. Nothing hidden must be adequate, what is outside of the catalogue
unexplained. Of a right one the 95 % interval must hold the hidden value. The lab searches six
effects, one of them at seven places (`SEARCHED`). Wanted: strong ones, and those of drawn strength
(cases from 14 on), right in 80 %, nothing hidden adequate in 95 %, as in the contract; with so few
cases all but one, and all.
"""

from __future__ import annotations

import numpy as np

from bench.command_line import chosen_cases
from bench.hands.verdicts import judge
from bench.hands_grasp.cases import PLAN, SEARCHED, SEED, Hidden, hidden_in
from bench.hands_grasp.measure import measured
from model_lab.measurements.measurement_set import MeasurementSet
from softhand_model.hand.hand import load_hand


def main() -> None:
    """Run the whole plan, or the cases of the numbers given, and print a row for each and sums."""
    numbers = chosen_cases("bench.hands_grasp", __doc__, len(PLAN))
    judge("hands_grasp", numbers, _case, "mN", SEARCHED)


def _case(number: int) -> tuple[Hidden, MeasurementSet]:
    random = np.random.default_rng(SEED + number)
    kind, strength, engine = PLAN[number]
    hidden = hidden_in(load_hand("rbo_hand_2"), kind, strength, random)
    return hidden, measured(hidden, engine, random)


if __name__ == "__main__":
    main()
