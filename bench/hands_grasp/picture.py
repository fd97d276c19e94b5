"""A cylinder of 1.6 times the stated mass, grasped in MuJoCo: `python -m bench.hands_grasp.picture
OUT.png` draws two models beside it, and prints their errors and the noise floor.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from bench.command_line import command_line
from bench.hands_grasp.cases import ELSEWHERE, SIZES, hidden_in
from bench.hands_grasp.measure import measured
from model_lab.bench.hand_grasp_set import hand_grasp_set
from model_lab.comparison.compare import errors_of
from model_lab.report.grasp_in_time import draw
from softhand_model.hand.hand import load_hand
from softhand_model.model_file import load_model

PICTURE_SEED = 5
SHOWN = ("usual", "near")  # protocols


def main(out: Path) -> None:
    """Draw, and print a line for each model."""
    random = np.random.default_rng(PICTURE_SEED)
    hidden = hidden_in(load_hand("rbo_hand_2"), "object_mass", "strong", random)
    empty = hand_grasp_set(random)
    empty = replace(empty, runs=tuple(run for run in empty.runs if run.protocol in SHOWN))
    data = measured(hidden, ELSEWHERE, random, empty)
    stated = load_model("gravity")
    heavy = replace(stated, effects=(*stated.effects, *hidden.effects))
    models = [("stated mass", stated), (f"{SIZES['object_mass']:g} times as much", heavy)]
    for name, model in models:
        found = errors_of(data, model)
        print(f"{name}: {found.as_is.rmse:.3f} N, floor {found.floor.total:.3f} N")
    draw(data, models, out)


if __name__ == "__main__":
    parser = command_line("bench.hands_grasp.picture", __doc__)
    parser.add_argument("out", type=Path, help="PNG file to be written")
    main(parser.parse_args().out)
