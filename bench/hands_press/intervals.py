"""Whether intervals of a pressed hand hold the truth: `python -m bench.hands_press.intervals
[NUMBERS]`, with another skin or step in MuJoCo `--compliance 2e-4 --step 1.25e-4`.

Hands with one effect are pressed in MuJoCo, with as many segments as the lab has, and the effect
that was hidden is fitted; nothing is searched. Fixed before the first run: these cases and seeds
(none of them of `bench.hands_press`), and that all intervals but one at the most hold the truth.
Prints the interval by noise alone, and that by noise and errors of the predictions themselves.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from bench.command_line import command_line, with_cases
from bench.hands_motion.measure import MODULUS_SCALES
from bench.hands_press.cases import SIZES, hidden_in
from bench.hands_press.engines import COARSE, FEW
from bench.hands_press.measure import noisy, pressed
from model_lab.bench.hand_press_set import PRESSES, hand_press_set
from model_lab.diagnosis.forward_selection import closer
from model_lab.diagnosis.result import Estimate, estimate
from model_lab.diagnosis.search import Scored, score_base, score_with
from model_lab.fitting.problem import FitProblem, pose_problem
from model_lab.measurements.measurement_set import MeasurementSet
from pneuflex_sim.engines.mujoco.compliance import RIGID_COMPLIANCE
from softhand_model.effects import effect_classes
from softhand_model.hand.hand import load_hand
from softhand_model.model_file import load_model

SEED = 8100  # of the first case; the others follow
PLAN = [
    ("friction", "strong"),
    ("wrench_gain", "weak"),
    ("friction", "weak"),
    ("actuator_scatter", "strong"),
    ("palm_stiffness", "strong"),
    ("strut_stiffness", "strong"),
]


def main() -> None:
    """Press, fit, and print Markdown."""
    parser = command_line("bench.hands_press.intervals", __doc__)
    text = "of skin and plate each in MuJoCo [m/N] (default: %(default)s)"
    parser.add_argument("--compliance", type=float, default=RIGID_COMPLIANCE, help=text)
    text = "in MuJoCo [s] (default: %(default)s)"
    parser.add_argument("--step", type=float, default=COARSE, help=text)
    given = with_cases(parser, len(PLAN))
    print("| hidden | value | by noise | and own errors | holds |\n|---|---|---|---|---|")
    for number in given.numbers:
        kind, strength = PLAN[number]
        random = np.random.default_rng(SEED + number)
        hidden = hidden_in(load_hand("rbo_hand_2"), kind, strength, random)
        empty, scale = hand_press_set(), float(random.uniform(*MODULUS_SCALES))
        truth = {
            run.protocol: pressed(hidden, empty, run, scale, FEW, given.step, given.compliance)
            for run in empty.runs[: len(PRESSES)]
        }
        data = _cut_alike(noisy(empty, truth, random))
        problem, _ = pose_problem(data, load_model(), {kind: effect_classes()[kind]})
        name = "".join([kind, *(f"[{place}]" for place in hidden.where.values())])
        scored = closer(problem, _scored(problem, name))
        plain = replace(scored, fit=replace(scored.fit, own_covariance=0.0))
        (index,) = scored.parameters_of(name)
        value = SIZES[kind][strength == "weak"]
        found = estimate(scored, index)
        holds = found.interval[0] <= value <= found.interval[1]
        noise, both = _said(estimate(plain, index)), _said(found)
        cells = (name, f"{value:g}", noise, both, "yes" if holds else "no")
        print("| " + " | ".join(cells) + " |", flush=True)


def _cut_alike(data: MeasurementSet) -> MeasurementSet:
    """The set of a simulated hand whose number of segments is known."""
    specimens = {
        name: replace(one, hand=replace(one.hand, segments=FEW))
        for name, one in data.specimens.items()
        if one.hand is not None
    }
    return replace(data, specimens=specimens)


def _scored(problem: FitProblem, name: str) -> Scored:
    """The model with an effect, fitted."""
    scored = score_with(problem, score_base(problem, []), name)
    if not isinstance(scored, Scored):
        raise ValueError(f"{name} does not show in the set: {scored.reason}")
    return scored


def _said(found: Estimate) -> str:
    return f"{found.value:.4f} ({found.interval[0]:.4f} to {found.interval[1]:.4f})"


if __name__ == "__main__":
    main()
