"""`model-lab synthesize`: measurements made by the model, with an effect to be found."""

from __future__ import annotations

import argparse
from pathlib import Path

from model_lab.cli import options
from model_lab.cli.progress import Progress

NOISE = 0.006
HELP = "make measurements with a hidden effect, to try the lab on"
DESCRIPTION = (
    "Make a measurement set with the model itself: two repeats of six protocols, with noise. "
    "EXPERIMENT is free_bending, blocked_tip, uniaxial, valve_pulse or base_torque. With --hide "
    "one effect acts in it that is sealed in the folder, and only `reveal` opens the seal. The "
    "CSV files are in the units that experiment.yaml states, such as kPa and deg."
)
EXAMPLES = (
    "model-lab synthesize free_bending --hide --seed 3 --out trial",
    "model-lab diagnose trial && model-lab reveal trial",
)


def add_to(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    parser.add_argument("experiment", metavar="EXPERIMENT", help="such as free_bending")
    parser.add_argument("--hide", action="store_true", help="hide an effect in it")
    parser.add_argument("--out", type=Path, required=True, metavar="DIR", help="folder to write")
    parser.add_argument(
        "--noise",
        type=float,
        default=NOISE,
        metavar="SHARE",
        help="one sigma over the largest reading, and scatter of whole runs (default: %(default)s)",
    )
    parser.add_argument(
        "--effects",
        type=Path,
        action="append",
        default=[],
        metavar="FILE",
        help="Python file with effects of your own: one of them is hidden",
    )
    options.add_seed(parser)
    options.add_results(parser)


def run(arguments: argparse.Namespace) -> None:
    """Make the set and write it."""
    from model_lab.bench.synthesize import synthesize, write_synthesised
    from model_lab.measurements.save import check_folder

    options.check_json(arguments)
    check_folder(arguments.out, arguments.force)
    own = options.own_classes(arguments)
    with Progress("measuring") as progress:
        made = synthesize(
            arguments.experiment,
            arguments.seed,
            arguments.hide,
            own or None,
            arguments.noise,
            progress,
        )
    write_synthesised(made, arguments.out, arguments.force)
    runs = len(made.data.runs)
    print(f"{arguments.out}: {made.data.title}, {runs} runs; the truth is sealed")
    content = {"format": "softhand-synthesis/1", "experiment": arguments.experiment}
    options.save_json(arguments, {**content, "folder": str(arguments.out), "runs": runs})
