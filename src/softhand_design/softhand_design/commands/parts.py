"""`softhand hand parts`: all parts of a hand other than the moulds of its actuators."""

from __future__ import annotations

import argparse
from dataclasses import fields
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from softhand_common.documents.output_file import check_new, save_figure
from softhand_design.kit.parameters import KitParameters
from softhand_model.hand.hand import load_hand

PARTS_FOLDER = Path("out/parts")


def add_to(commands: Any) -> None:
    """Add the command to the subparsers of `hand`."""
    found = commands.add_parser(
        "parts",
        help="scaffold, passive layers, palm sheet and bill of a hand",
        description="Write what a hand needs beside the moulds of its actuators: scaffold, saddles "
        "and trays as STL [mm], mesh as SVG, what the moulds give for comparison, a bill of "
        "materials, a picture of all parts together, and a report of checks. Parts that fail a "
        "check are refused.",
    )
    add = found.add_argument
    add("hand", help="a shipped hand, or the path of a hand's YAML")
    add("-o", "--out", type=Path, default=PARTS_FOLDER, help="folder (%(default)s)")
    add("--force", action="store_true", help="overwrite files in it")
    for entry in fields(KitParameters):
        option = f"--{entry.name.replace('_', '-')}"
        about = f"{entry.metadata['text']} [mm] (%(default)s)"
        add(option, type=float, default=entry.default, help=about)
    found.set_defaults(run=run)


def run(options: argparse.Namespace) -> None:
    """Make, check and write; raises ValueError for what cannot be made or fails a check."""
    if find_spec("manifold3d") is None:
        raise ValueError("parts: expected the package manifold3d, got none: pip install manifold3d")
    # late: manifold3d and matplotlib are extras, PyBullet talks when it starts
    from softhand_design.drawings.assembled_picture import draw_assembled
    from softhand_design.kit.kit import build_kit
    from softhand_design.kit.report import checked_kit, paths_of, terminal_text, write_kit

    used = KitParameters(**{e.name: getattr(options, e.name) for e in fields(KitParameters)})
    kit = build_kit(load_hand(options.hand), used)
    paths = paths_of(kit, options.out)
    for path in paths.values():
        check_new(path, options.force)
    made = checked_kit(kit)
    write_kit(made, options.out)
    save_figure(draw_assembled(kit), paths["picture"])
    print(terminal_text(made))
    print("\n".join(str(path) for path in paths.values()))
