"""`model-lab plan`: the experiment to do next."""

from __future__ import annotations

import argparse

from model_lab.commands import options

HELP = "the next experiment, which would separate what is still tied"
DESCRIPTION = (
    "Diagnose, and propose the experiment in which the effects that the data cannot tell "
    "apart differ most, within the pressures and rates that the set has seen. Pressures are shown "
    "in kPa, times in s, temperatures in degC; --json is in SI units."
)
EXAMPLES = ("model-lab plan out/set --model base --out out/next",)


def add_to(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    options.add_data(parser)
    options.add_model(parser)
    options.add_effects(parser)
    options.add_results(parser)
    options.add_seed(parser)
    options.add_jobs(parser)


def run(arguments: argparse.Namespace) -> None:
    """Diagnose, plan, print, and write the JSON."""
    from model_lab.diagnose import diagnose
    from model_lab.diagnosis_text import diagnosis_text
    from model_lab.progress import Progress

    options.check_json(arguments)
    model = options.model(arguments)
    classes = options.classes(arguments, model)
    data = options.measurements(arguments)
    with Progress("diagnosing and planning"):
        outcome = diagnose(data, model, classes, arguments.seed, arguments.jobs)
    print(diagnosis_text(outcome.diagnosis), end="")
    options.save_json(arguments, outcome.diagnosis.as_json())
