"""`model-lab reveal`: opens the seal of synthesised measurements."""

from __future__ import annotations

import argparse
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from model_lab.cli import options

HELP = "say what was hidden in synthesised measurements"
DESCRIPTION = (
    "Open the seal of a set that `synthesize --hide` made, and say what acts in it, in SI units."
)
EXAMPLES = ("model-lab reveal trial",)


def add_to(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    parser.add_argument("folder", type=Path, metavar="DIR", help="folder of the set")
    options.add_results(parser)


def run(arguments: argparse.Namespace) -> None:
    """Open the seal and print what is in it."""
    from model_lab.bench.synthesize import open_seal

    options.check_json(arguments)
    truth = open_seal(arguments.folder)
    for effect in truth["effects"]:
        values = ", ".join(f"{name} = {value:.4g}" for name, value in effect["parameters"].items())
        print(f"hidden: {effect['name']} ({values})" if values else f"hidden: {effect['name']}")
    if not truth["effects"]:
        print("hidden: nothing")
    print(f"calibration (SI units): {_calibration(truth['calibration'])}")
    print(f"noise, one sigma (SI units): {truth['noise']:.3g}")
    options.save_json(arguments, {"format": "softhand-truth/1", **truth})


def _calibration(entries: Mapping[str, Any]) -> str:
    """Numbers of a calibration, by name and batch or alone."""
    return ", ".join(
        f"{name} {_calibration(entry)}" if isinstance(entry, Mapping) else f"{name} {entry:.4g}"
        for name, entry in entries.items()
    )
