"""`model-lab add`: an effect more in the model."""

from __future__ import annotations

import argparse
from pathlib import Path

from model_lab.cli import options
from model_lab.cli.progress import Progress

HELP = "add an effect to the model, fitted to the data"
DESCRIPTION = (
    "Fit the model together with one more effect and write the model file that simulator, "
    "monitor and lab load. `add discrepancy` adds a generic term, marked as not physics, for when "
    "no known effect explains the error. Units: see docs/effects.md."
)
EXAMPLES = (
    "model-lab add gent_stiffening --data out/set --model base --out model.yaml",
    "model-lab add discrepancy --data out/set --model base --out working.yaml",
)


def add_to(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    parser.add_argument("effect", metavar="EFFECT", help="name of the effect")
    parser.add_argument("--data", type=Path, required=True, metavar="DATA", help="measurements")
    options.add_model(parser)
    parser.add_argument(
        "--out", type=Path, required=True, metavar="M2", help="the model file to write"
    )
    options.add_effects(parser)
    options.add_results(parser)


def run(arguments: argparse.Namespace) -> None:
    """Fit, print what was found, and write the model file and the JSON."""
    from dataclasses import replace

    from model_lab.comparison.add import add_effect, check_model_file, write_model
    from model_lab.report.text import addition_json, addition_text

    options.check_json(arguments)
    check_model_file(arguments.out, arguments.force)
    model = options.model(arguments)
    classes = options.classes(arguments, model)
    data = options.measurements(arguments)
    with Progress("adding") as progress:
        addition = add_effect(arguments.effect, data, model, classes, progress)
    known = {effect.name for effect in addition.model.effects}
    own = {name: path for name, path in options.files(arguments).items() if name in known}
    written = replace(addition.model, files={**model.files, **own})
    comment = (
        f"{arguments.effect} added to {arguments.model}, fitted to {data.title or data.experiment}"
    )
    write_model(arguments.out, written, comment, arguments.force)
    print(addition_text(addition, arguments.out), end="")
    options.save_json(arguments, addition_json(addition, str(arguments.out)))
