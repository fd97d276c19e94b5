"""Hidden effects that a seed draws: `python -m bench.hands.drawn --seed N` makes 120 sets, as
`bench.hands` makes its own, and judges them by its criteria. With `--experiment hand_motion`, hands
move, as in `bench.hands_motion`; with `press` they are pressed on a plate, as in
`bench.hands_press`. A stopped run continues.

Fixed before any set was run: the cases come in rounds, so that the first ones are a sample of all.
Kinds of a group come in an order that is drawn. A size lies between strong and weak of `SIZES`,
nearer to the one that it is called. Two effects are any two kinds, both strong. Motions and presses
are drawn, too (`measured_as_drawn`).

Targets, for all seeds together: right, or tied with at most two others, 95 % of strong and 80 % of
weak effects, of both at most 4 % wrong, and the right place in 95 % of those whose name is right;
nothing hidden 95 %; outside 90 %; two 85 %; slips 90 %; no control wrong; error at most 2 floors
after adding in 90 %; 90 to 98 % of intervals hold the truth. Of motions: right 90 % of strong
effects; and 12 sets in at most 300 s on two cores, that is, 50 s of processor time each. Seeds of
motions, each chosen before its first run: 97701, and cases 0 to 19 of 97801. Of presses: right 90 %
of strong effects and 95 % of nothing hidden, 12 sets in at most 600 s on two cores; seed 97901,
chosen before its first run, cases 0 to 39.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import permutations

import numpy as np

from bench.command_line import command_line, with_cases
from bench.hands import cases
from bench.hands.cases import CONTROLS, OUTSIDE, Hidden, hidden_in
from bench.hands.measure import HAND, Protocols, measured_with_slip
from bench.hands.slips import SLIPS
from bench.hands.verdicts import judge
from bench.hands_motion.cases import CONTROL
from bench.hands_motion.cases import SIZES as SIZES_IN_MOTION
from bench.hands_motion.measure import measured_as_drawn
from bench.hands_press import cases as pressed
from bench.hands_press.measure import measured_as_drawn as pressed_as_drawn
from model_lab.measurements.hands import HAND_MOTION, HAND_POSE, PRESS
from model_lab.measurements.measurement_set import MeasurementSet
from softhand_model.hand.hand import load_hand

DRAWN = 120  # cases of a seed
FIRST_HALF = ("strong", "nothing", "weak", "two", "outside", "strong", "slip", "weak", "strong")
OTHER_HALF = ("control", "weak", "strong", "outside", "two", "strong", "nothing", "weak", "slip")
NEARER = {"strong": (0.0, 0.4), "weak": (0.6, 1.0), "two": (0.0, 0.4)}  # share of the way to weak
OF_MOTION = {  # sizes of what a motion shows
    **SIZES_IN_MOTION,
    **{
        kind: cases.SIZES[kind]
        for kind in ("strut_stiffness", "palm_stiffness", "marker_offset", "frame_tilt")
    },
}


@dataclass(frozen=True)
class Plan:
    """The sets of an experiment: groups of one round, sizes (strong, weak) of the effects, and
    kinds of the groups `control` and `outside`; bench and unit of what is printed.
    """

    round: Sequence[str]
    sizes: Mapping[str, tuple[float, float]]
    controls: Sequence[str]
    outside: Sequence[str]
    bench: str
    unit: str = "mm"

    @property
    def groups(self) -> dict[str, tuple[str, ...]]:
        """Kinds of each group."""
        return {
            "strong": tuple(self.sizes),
            "weak": tuple(self.sizes),
            "nothing": ("nothing",),
            "outside": tuple(self.outside),
            "two": tuple(" and ".join(pair) for pair in permutations(self.sizes, 2)),
            "slip": tuple(SLIPS),
            "control": tuple(self.controls),
        }


MOVING_FIRST = ("strong", "nothing", "strong", "weak", "strong", "slip")
MOVING_LAST = ("strong", "outside", "strong", "nothing", "weak", "control")
PRESSED_FIRST = ("strong", "nothing", "strong", "weak", "strong")
PRESSED_LAST = ("outside", "strong", "nothing", "strong", "control")
OUTSIDE_PRESSED = ("gent_stiffening",)  # not in the catalogue of presses
OF_PRESS = {kind: size for kind, size in pressed.SIZES.items() if kind not in OUTSIDE_PRESSED}
ROUND = (*FIRST_HALF, "strong", *OTHER_HALF, "strong")
ROUND_MOVING, ROUND_PRESSED = (*MOVING_FIRST, *MOVING_LAST), (*PRESSED_FIRST, *PRESSED_LAST)
PLANS = {
    HAND_POSE: Plan(ROUND, cases.SIZES, CONTROLS, (*OUTSIDE,), "hands"),
    HAND_MOTION: Plan(ROUND_MOVING, OF_MOTION, (CONTROL,), (*OUTSIDE,), "hands_motion"),
    PRESS: Plan(ROUND_PRESSED, OF_PRESS, (pressed.CONTROL,), OUTSIDE_PRESSED, "hands_press", "mN"),
}


@dataclass(frozen=True)
class Drawn:
    """A case: kind and group of what is hidden, its share of the way from strong to weak, and how
    poses are measured.
    """

    kind: str
    group: str
    share: float
    protocols: Protocols


def drawn(seed: int, number: int, experiment: str = HAND_POSE) -> Drawn:
    """A case of a seed."""
    plan = PLANS[experiment]
    group = plan.round[number % len(plan.round)]
    earlier = sum(plan.round[before % len(plan.round)] == group for before in range(number))
    kinds, names = plan.groups[group], list(plan.groups)
    order = np.random.default_rng([seed, names.index(group)]).permutation(len(kinds))
    random = np.random.default_rng([seed, len(names), number])
    name = "" if group == "nothing" else group
    share = float(random.uniform(*NEARER.get(group, (0.0, 0.0))))
    how = Protocols(
        count=int(random.integers(4, 7)),
        poses=int(random.integers(6, 11)),
        marker_noise=float(random.uniform(0.3e-3, 0.8e-3)),
        reach=float(random.uniform(0.75, 1.0)),
    )
    return Drawn(kinds[order[earlier % len(kinds)]], name, share, how)


def case(experiment: str, seed: int, number: int) -> tuple[Hidden, MeasurementSet]:
    """What is hidden in a case of a seed, and its set."""
    one, random = drawn(seed, number, experiment), np.random.default_rng([seed, number])
    if experiment == PRESS:
        hidden = pressed.hidden_in(load_hand(HAND), one.kind, one.group, random, one.share)
        return hidden, pressed_as_drawn(hidden, random)
    sizes = PLANS[experiment].sizes
    hidden = hidden_in(load_hand(HAND), one.kind, one.group, random, one.share, sizes)
    if experiment == HAND_MOTION:
        return measured_as_drawn(hidden, random)
    return measured_with_slip(hidden, random, one.protocols)


def main() -> None:
    """Run the cases of a seed, or those of the numbers given."""
    parser = command_line("bench.hands.drawn", __doc__)
    parser.add_argument("--seed", type=int, required=True, help="draws the cases")
    text = "(default: %(default)s)"
    parser.add_argument("--experiment", choices=[*PLANS], default=HAND_POSE, help=text)
    given = with_cases(parser, DRAWN)
    make, plan = partial(case, given.experiment, given.seed), PLANS[given.experiment]
    judge(plan.bench, given.numbers, make, plan.unit, seed=given.seed)


if __name__ == "__main__":
    main()
