"""Hidden effects of hands: `python -m bench.hands` makes the sets, diagnoses them, prints Markdown.

Criteria, fixed before the first run: a set is *right* if the verdict is effects_missing with one
effect, the hidden one at its place; *tied* if the hidden one is among what is tied with it; else
*wrong* if something is named. Nothing hidden must be adequate, what is outside of the catalogue
unexplained. In a negative control (markers or pressures shuffled, another hand's model) nothing
must be named, and the model must not be adequate. Of two effects both must be named at their places
and nothing else, of a slip its name and columns, and no effect. Wrong sensors of a channel (cases
61 to 66) may be tied, too, where the channel feeds one actuator; none may be *wrong*. A verdict is
*sure* if it has a confidence that is no guess. Of a right one with a single parameter, the 95 %
interval must hold the hidden value.
"""

from __future__ import annotations

import numpy as np

from bench.command_line import chosen_cases
from bench.hands.cases import HIGHEST, PLAN, SEED, Hidden, hidden_in
from bench.hands.measure import HAND, measured_with_slip
from bench.hands.verdicts import judge
from model_lab.measurements.measurement_set import MeasurementSet
from softhand_model.effects.load import STANDARD_GRAVITY
from softhand_model.equilibrium.hand_statics import settled_hand
from softhand_model.hand.hand import load_hand
from softhand_model.model_file import load_model

SEGMENTS_COMPARED, FINE, CONVERGENCE_POSES = (5, 20), 80, 72


def main() -> None:
    """Run the whole plan, or the cases of the numbers given, and print a row for each and sums."""
    numbers = chosen_cases("bench.hands", __doc__, len(PLAN))
    for segments in SEGMENTS_COMPARED:
        error = 1e3 * error_of_segments(segments)
        print(f"{segments} segments an actuator: tips {error:.2f} mm (rms) from those of {FINE}")
    judge("hands", numbers, _case, "mm")


def _case(number: int) -> tuple[Hidden, MeasurementSet]:
    random = np.random.default_rng(SEED + number)
    return measured_with_slip(hidden_in(load_hand(HAND), *PLAN[number], random), random)


def error_of_segments(segments: int) -> float:
    """Distance [m], root mean square over drawn poses and tips, of the worst tip of the statics
    from that with FINE segments.
    """
    hand, random = load_hand(HAND), np.random.default_rng(SEED)
    pressures = random.uniform(0.0, 1.0, (CONVERGENCE_POSES, len(hand.channels))).T
    pressures *= np.array(HIGHEST)[:, None]
    down = random.standard_normal((CONVERGENCE_POSES, 3))
    pull = STANDARD_GRAVITY * down / np.linalg.norm(down, axis=1)[:, None]
    coarse, fine = (
        [
            body.point(shape, name, 1.0, np.zeros(3))
            for body, shape in settled_hand(hand, load_model(), count, pressures, pull)
            for name in body.joints
            if name in hand.tips
        ]
        for count in (segments, FINE)
    )
    square = np.sum(np.subtract(coarse, fine) ** 2, axis=2)
    return float(np.max(np.sqrt(np.mean(square, axis=1))))


if __name__ == "__main__":
    main()
