"""`model-lab diagnose`: what the model lacks."""

from __future__ import annotations

import argparse
import shlex
from pathlib import Path

from model_lab.cli import options
from model_lab.cli.progress import Progress

HELP = "which physical effect is missing"
DESCRIPTION = (
    "Search the known effects, and your own, for what the model lacks. Names an effect "
    "only if it removes at least half of the excess error on held-out data; else says "
    "`adequate` or `unexplained`. Errors are shown in deg, kPa, mg or N mm, parameters in the "
    "units of docs/effects.md; --json is in SI units."
)
EXAMPLES = (
    "model-lab diagnose out/set --model base --report out/report",
    "model-lab diagnose out/set --effects examples/own_effect.py --jobs 2",
)
REPORT = "report.html"


def add_to(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    options.add_data(parser)
    options.add_model(parser)
    options.add_effects(parser)
    parser.add_argument(
        "--report", type=Path, metavar="DIR", help=f"folder in which to write {REPORT}"
    )
    options.add_results(parser)
    options.add_seed(parser)
    options.add_jobs(parser)


def run(arguments: argparse.Namespace) -> None:
    """Diagnose, print the verdict, and write JSON and report."""
    from model_lab.diagnosis.diagnose import diagnose
    from model_lab.report.text import diagnosis_text
    from softhand_model.output_file import check_new

    options.check_json(arguments)
    if arguments.report is not None:
        check_new(arguments.report / REPORT, arguments.force)
    model = options.model(arguments)
    classes = options.classes(arguments, model)
    data = options.measurements(arguments)
    with Progress("diagnosing") as progress:
        outcome = diagnose(data, model, classes, arguments.seed, arguments.jobs, progress)
    print(diagnosis_text(outcome.diagnosis), end="")
    options.save_json(arguments, outcome.diagnosis.as_json())
    if arguments.report is not None:
        from model_lab.report import write_report

        arguments.report.mkdir(parents=True, exist_ok=True)
        write_report(outcome, arguments.report / REPORT, _commands(arguments))


def _commands(arguments: argparse.Namespace) -> list[str]:
    """The lines that make the report again."""
    words = ["model-lab", "diagnose", str(arguments.data), "--model", arguments.model]
    for path in arguments.effects:
        words += ["--effects", str(path)]
    words += ["--seed", str(arguments.seed), "--report", str(arguments.report), "--force"]
    return [shlex.join(words)]
