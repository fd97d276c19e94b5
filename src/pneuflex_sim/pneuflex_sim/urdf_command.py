"""`hand urdf`: the URDF of a hand, as the simulator publishes it on `robot_description`."""

from __future__ import annotations

import argparse
from pathlib import Path

from pneuflex_sim.layout import build_layout
from pneuflex_sim.new_file import check_new
from pneuflex_sim.urdf import write_urdf
from softhand_model.hands import load_hand
from softhand_model.model_file import load_model


def add_urdf(commands: argparse._SubParsersAction) -> None:
    """Add the command to the parsers of `hand`."""
    parser = commands.add_parser(
        "urdf", help="write the URDF of a hand", description="Write the URDF of a hand."
    )
    parser.add_argument("hand", help="name of a shipped hand or path of its YAML")
    parser.add_argument(
        "--segments", type=int, default=5, help="an actuator, as in the simulator (%(default)s)"
    )
    parser.add_argument("-o", "--out", type=Path, help="file (standard output)")
    parser.add_argument("--force", action="store_true", help="overwrite that file")
    parser.set_defaults(run=run_urdf)


def run_urdf(options: argparse.Namespace) -> None:
    """Write it; raises ValueError for a hand that does not exist or has too many segments."""
    if options.segments < 1:
        raise ValueError(f"segments: expected 1 or more, got {options.segments}")
    if options.out is not None:
        check_new(options.out, options.force)
    text = write_urdf(build_layout(load_hand(options.hand), options.segments, load_model(None)))
    if options.out is None:
        print(text)
        return
    options.out.parent.mkdir(parents=True, exist_ok=True)
    options.out.write_text(text + "\n", encoding="utf-8")
