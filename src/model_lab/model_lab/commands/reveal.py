"""`model-lab reveal`: opens the seal of synthesised measurements."""

from __future__ import annotations

import argparse
from pathlib import Path

from model_lab.commands import options

HELP = "say what was hidden in synthesised measurements"
DESCRIPTION = "Open the seal of a set that `synthesize --hide` made, and say what acts in it."


def add_to(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    parser.add_argument("folder", type=Path, metavar="DIR", help="folder of the set")
    options.add_results(parser)


def run(arguments: argparse.Namespace) -> None:
    """Open the seal and print what is in it."""
    from model_lab.seal import open_seal

    options.check_json(arguments)
    truth = open_seal(arguments.folder)
    for effect in truth["effects"]:
        values = ", ".join(f"{name} = {value:.4g}" for name, value in effect["parameters"].items())
        print(f"hidden: {effect['name']} ({values})" if values else f"hidden: {effect['name']}")
    if not truth["effects"]:
        print("hidden: nothing")
    print(f"modulus scale {truth['modulus_scale']:.4g}, noise {truth['noise']:.3g} (SI units)")
    options.save_json(arguments, {"format": "softhand-truth/1", **truth})
