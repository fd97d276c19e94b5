"""Hidden effects that a seed draws: `python -m bench.hands.drawn --seed N` makes 120 sets, as
`bench.hands` makes its own, and judges them by its criteria. A stopped run continues.

Fixed before any set was run: the cases come in rounds of ROUND, so that the first ones are a sample
of all. Kinds of a group come in an order that is drawn. A size lies between strong and weak of
`SIZES`, nearer to the one that it is called. Two effects are any two kinds, both strong.

Targets, for all seeds together: right, or tied with at most two others, 95 % of strong and 80 % of
weak effects, of both at most 4 % wrong, and the right place in 95 % of those whose name is right;
nothing hidden 95 %; outside 90 %; two 85 %; slips 90 %; no control wrong; error at most 2 floors
after adding in 90 %; 90 to 98 % of intervals hold the truth.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from itertools import permutations

import numpy as np

from bench.command_line import command_line, with_cases
from bench.hands.cases import CONTROLS, OUTSIDE, SIZES, Hidden, hidden_in
from bench.hands.measure import HAND, Protocols, measured_with_slip
from bench.hands.slips import SLIPS
from bench.hands.verdicts import judge
from model_lab.measurements.measurement_set import MeasurementSet
from softhand_model.hand.hand import load_hand

DRAWN = 120  # cases of a seed
FIRST_HALF = ("strong", "nothing", "weak", "two", "outside", "strong", "slip", "weak", "strong")
OTHER_HALF = ("control", "weak", "strong", "outside", "two", "strong", "nothing", "weak", "slip")
ROUND = (*FIRST_HALF, "strong", *OTHER_HALF, "strong")
NEARER = {"strong": (0.0, 0.4), "weak": (0.6, 1.0), "two": (0.0, 0.4)}  # share of the way to weak
GROUPS = {
    "strong": tuple(SIZES),
    "weak": tuple(SIZES),
    "nothing": ("nothing",),
    "outside": tuple(OUTSIDE),
    "two": tuple(" and ".join(pair) for pair in permutations(SIZES, 2)),
    "slip": tuple(SLIPS),
    "control": CONTROLS,
}


@dataclass(frozen=True)
class Drawn:
    """A case: kind and group of what is hidden, its share of the way from strong to weak, and how
    it is measured.
    """

    kind: str
    group: str
    share: float
    protocols: Protocols


def drawn(seed: int, number: int) -> Drawn:
    """A case of a seed."""
    group = ROUND[number % len(ROUND)]
    earlier = sum(ROUND[before % len(ROUND)] == group for before in range(number))
    kinds = GROUPS[group]
    order = np.random.default_rng([seed, list(GROUPS).index(group)]).permutation(len(kinds))
    random = np.random.default_rng([seed, len(GROUPS), number])
    name = "" if group == "nothing" else group
    share = float(random.uniform(*NEARER.get(group, (0.0, 0.0))))
    how = Protocols(
        count=int(random.integers(4, 7)),
        poses=int(random.integers(6, 11)),
        marker_noise=float(random.uniform(0.3e-3, 0.8e-3)),
        reach=float(random.uniform(0.75, 1.0)),
    )
    return Drawn(kinds[order[earlier % len(kinds)]], name, share, how)


def case(seed: int, number: int) -> tuple[Hidden, MeasurementSet]:
    """What is hidden in a case of a seed, and its set."""
    one, random = drawn(seed, number), np.random.default_rng([seed, number])
    hidden = hidden_in(load_hand(HAND), one.kind, one.group, random, one.share)
    return measured_with_slip(hidden, random, one.protocols)


def main() -> None:
    """Run the cases of a seed, or those of the numbers given."""
    parser = command_line("bench.hands.drawn", __doc__)
    parser.add_argument("--seed", type=int, required=True, help="draws the cases")
    given = with_cases(parser, DRAWN)
    judge("hands", given.numbers, partial(case, given.seed), "mm", seed=given.seed)


if __name__ == "__main__":
    main()
