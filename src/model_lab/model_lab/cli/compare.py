"""`model-lab compare`: how far a model is off, and where."""

from __future__ import annotations

import argparse

from model_lab.cli import options
from model_lab.cli.progress import Progress

HELP = "how far a model is off, and where"
DESCRIPTION = (
    "Compare a model with measurements: error over all data and held out, fit in percent, "
    "the noise floor, and where the error lies: against pressure, rate, time, history, "
    "temperature and specimen. Tables show units as at the bench (deg, kPa, mg, N mm); --json is "
    "in SI units."
)
EXAMPLES = (
    "model-lab compare out/set --model base",
    "model-lab compare out/set --model model.yaml --json after.json",
)


def add_to(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    options.add_data(parser)
    options.add_model(parser)
    options.add_effects(parser)
    options.add_results(parser)
    options.add_seed(parser)


def run(arguments: argparse.Namespace) -> None:
    """Compare, print, and write the JSON."""
    from model_lab.comparison.compare import compare
    from model_lab.report.comparison_text import comparison_json, comparison_text

    options.check_json(arguments)
    model = options.model(arguments)
    data = options.measurements(arguments)
    with Progress("comparing") as progress:
        found = compare(data, model, arguments.seed, progress)
    print(comparison_text(found, arguments.model), end="")
    options.save_json(arguments, comparison_json(found, arguments.model))
