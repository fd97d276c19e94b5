"""How much damping the time step of the simulator adds: `python -m bench.hands_motion.time_step`.

Hands without any effect move as in two protocols of the lab's planned set; the lab fits the time
of `joint_damping`, which is 10 ms in the model of the simulator. Prints a row for each engine and
step.
"""

from __future__ import annotations

import numpy as np

from bench.command_line import command_line
from bench.hands.cases import Hidden
from bench.hands_motion.measure import Simulated, measured
from model_lab.bench.hand_motion_set import HAND_MOTIONS
from model_lab.diagnosis.result import estimate
from model_lab.diagnosis.search import Scored, score_base, score_with
from model_lab.fitting.problem import pose_problem
from pneuflex_sim.engines import MUJOCO, PYBULLET
from softhand_model.effects import effect_classes
from softhand_model.hand.hand import load_hand
from softhand_model.hand.joint_stiffness import DAMPING_TIME
from softhand_model.model_file import load_model

SEED, PROTOCOLS, SEGMENTS = 3, 2, 5
STEPS = {PYBULLET: (0.002, 0.001, 0.0005), MUJOCO: (0.002, 0.0005)}  # [s]
DAMPING = "joint_damping"


def main() -> None:
    """Move the hands, fit, and print Markdown."""
    command_line("bench.hands_motion.time_step", __doc__).parse_args()
    nothing = Hidden(load_hand("rbo_hand_2"), "nothing", "")
    motions = dict([*HAND_MOTIONS.items()][:PROTOCOLS])
    print("| engine | step [ms] | damping, with its 95 % interval [ms] | added, in steps |")
    print("|---|---|---|---|")
    for engine, steps in STEPS.items():
        for step in steps:
            random, simulated = np.random.default_rng(SEED), Simulated(engine, SEGMENTS, step)
            data = measured(nothing, random, motions, simulated=simulated)
            problem, _ = pose_problem(data, load_model(), {DAMPING: effect_classes()[DAMPING]})
            scored = score_with(problem, score_base(problem, []), DAMPING)
            if not isinstance(scored, Scored):
                raise ValueError(f"{DAMPING} does not show in the set: {scored.reason}")
            (index,) = scored.parameters_of(DAMPING)
            found = estimate(scored, index)
            low, high = (1e3 * bound for bound in found.interval)
            print(
                f"| {engine} | {1e3 * step:g} | {1e3 * found.value:.2f} ({low:.2f} to {high:.2f}) "
                f"| {(found.value - DAMPING_TIME) / step:.2f} |",
                flush=True,
            )


if __name__ == "__main__":
    main()
