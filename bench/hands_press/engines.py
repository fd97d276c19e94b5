"""What two engines make of the same press: `python -m bench.hands_press.engines [SEGMENTS STEP]`.

A hand without any effect or noise is pressed in MuJoCo and by the lab, with as many segments in
both. Prints the difference of the wrench over the size of force and torque, root mean square over
the lab's six planned protocols, its correlation time, and by how much MuJoCo is ahead in time, that
is the slope of the difference over the rate of the wrench: the sources of `Rules.press_engine`,
`press_engine_time` and `press_engine_lead`.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from bench.command_line import command_line
from bench.hands.cases import Hidden
from bench.hands_press.measure import pressed
from model_lab.bench.hand_press_set import PRESS_RATE, PRESSES, hand_press_set
from model_lab.experiments.hand_press import PRESS_STEP, HandPress
from model_lab.measurements.hands import WRENCH_COLUMNS, WRIST_POSE
from softhand_common.numerics.arrays import Array
from softhand_model.effects.load import Gravity

FEW, COARSE = 8, 5e-4  # segments of an actuator; step in MuJoCo [s]


def main() -> None:
    """Press, compare, and print Markdown."""
    parser = command_line("bench.hands_press.engines", __doc__)
    parser.add_argument("segments", nargs="?", type=int, default=FEW, help="default: %(default)s")
    text = "in MuJoCo [s] (default: %(default)s)"
    parser.add_argument("step", nargs="?", type=float, default=COARSE, help=text)
    given = parser.parse_args()
    segments, step = given.segments, given.step
    empty, runs = hand_press_set(), []
    nothing = Hidden(empty.hand, "nothing", "")
    for run in empty.runs[: len(PRESSES)]:
        wrench, wrist = pressed(nothing, empty, run, 1.0, segments, step)
        columns = dict(zip((*WRENCH_COLUMNS, *WRIST_POSE), [*wrench.T, *wrist.T], strict=True))
        runs.append(replace(run, columns=run.columns | columns))
    data = replace(empty, runs=tuple(runs))
    predicted = HandPress(data, segments, PRESS_STEP).predict({}, [Gravity(mass_scale=1.0)])[0]
    print("| protocol | force | difference | over size | correlation time | ahead |")
    print("|---|---|---|---|---|---|")
    squares = []
    for index, run in enumerate(runs):
        found = np.array(data.table.of_run(predicted, index)).reshape(2, 3, -1)
        apart = np.array(data.table.of_run(data.table.value, index)).reshape(2, 3, -1) - found
        size = np.linalg.norm(found, axis=1)
        rate = np.gradient(found, 1.0 / PRESS_RATE, axis=-1)
        lead = np.sum(rate * apart) / np.sum(rate**2)
        squares.append([np.mean(apart**2), np.mean(size**2), _next_product(apart), lead**2])
        print(_row(run.protocol, squares[-1]))
    print(_row("all", np.mean(squares, axis=0).tolist()))


def _next_product(apart: Array) -> float:
    """Mean product of differences one sample apart."""
    return float(np.mean(apart[..., 1:] * apart[..., :-1]))


def _row(name: str, sums: list[float]) -> str:
    square, size, after, lead = sums
    time = -1.0 / (PRESS_RATE * np.log(after / square))
    return (
        f"| {name} | {np.sqrt(size):.2f} N | {1e3 * np.sqrt(square):.1f} mN "
        f"| {np.sqrt(square / size):.4f} | {time:.2f} s | {1e3 * np.sqrt(lead):.1f} ms |"
    )


if __name__ == "__main__":
    main()
