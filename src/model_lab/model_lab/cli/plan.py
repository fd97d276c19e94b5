"""`model-lab plan`: the experiment to do next."""

from __future__ import annotations

import argparse
from pathlib import Path

from model_lab.cli import options
from model_lab.cli.progress import Progress

HELP = "the next experiment, which would separate what is still tied"
DESCRIPTION = (
    "Diagnose, and propose the experiment in which the effects that the data cannot tell "
    "apart differ most, within the pressures that the set has seen. With --out it is written as a "
    "template: a CSV file of time [s] and pressure [kPa] to be played, and the part of "
    "experiment.yaml for it. --json is in SI units."
)
EXAMPLES = (
    "model-lab plan out/set --model base --out out/next",
    "model-lab plan out/set --model model.yaml --json next.json",
)


def add_to(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    options.add_data(parser)
    options.add_model(parser)
    options.add_effects(parser)
    parser.add_argument("--out", type=Path, metavar="DIR", help="folder for the run's template")
    options.add_results(parser)
    options.add_seed(parser)
    options.add_jobs(parser)


def run(arguments: argparse.Namespace) -> None:
    """Diagnose, print what to do next, and write template and JSON."""
    from model_lab.diagnosis.diagnose import diagnose
    from model_lab.measurements.save import check_folder
    from model_lab.report.text import plan_json, plan_text, write_template

    options.check_json(arguments)
    if arguments.out is not None:
        check_folder(arguments.out, arguments.force)
    model = options.model(arguments)
    classes = options.classes(arguments, model)
    data = options.measurements(arguments)
    with Progress("diagnosing and planning") as progress:
        outcome = diagnose(data, model, classes, arguments.seed, arguments.jobs, progress)
    diagnosis = outcome.diagnosis
    print(plan_text(diagnosis), end="")
    files = []
    if diagnosis.next_experiment is not None and arguments.out is not None:
        arguments.out.mkdir(parents=True, exist_ok=True)
        files = write_template(diagnosis.next_experiment, data, arguments.out)
        print(f"Written: {', '.join(map(str, files))}")
    options.save_json(arguments, plan_json(diagnosis, files))
