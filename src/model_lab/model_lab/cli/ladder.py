"""`model-lab ladder`: the errors of several models side by side."""

from __future__ import annotations

import argparse

from model_lab.cli import options
from model_lab.cli.progress import Progress

HELP = "the errors of several models, side by side"
DESCRIPTION = (
    "Compare several models with the same measurements: one rung for each, with the noise "
    "floor below which no model can go. Errors are shown in deg, kPa, mg or N mm; --json is in SI "
    "units."
)
EXAMPLES = ("model-lab ladder out/set base gravity model.yaml",)


def add_to(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    options.add_data(parser)
    parser.add_argument(
        "models", nargs="+", metavar="MODEL", help="model file, or the name of a shipped one"
    )
    options.add_effects(parser)
    options.add_results(parser)


def run(arguments: argparse.Namespace) -> None:
    """Compare the models, print the rungs, and write the JSON."""
    from model_lab.comparison.ladder import compare_models, ladder_json, ladder_text

    options.check_json(arguments)
    models = {name: options.named_model(arguments, name) for name in arguments.models}
    data = options.measurements(arguments)
    with Progress("comparing") as progress:
        ladder = compare_models(data, models, progress)
    print(ladder_text(ladder), end="")
    options.save_json(arguments, ladder_json(ladder))
