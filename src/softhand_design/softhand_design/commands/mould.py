"""`softhand hand mould`: moulds of an actuator, or of all of a hand's on one printing bed."""

from __future__ import annotations

import argparse
from dataclasses import fields
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from softhand_common.documents.output_file import UnwritableFile, check_new, save_figure
from softhand_design.mould.parameters import MouldParameters
from softhand_model.hand.actuator import Actuator, actuator_names, load_actuator
from softhand_model.hand.hand import hand_names, load_hand

FOLDER = Path("out/mould")
BED = (256.0, 256.0)


def add_to(commands: Any) -> None:
    """Add the command to the subparsers of `hand`."""
    found = commands.add_parser(
        "mould",
        help="casting mould of an actuator, or of all of a hand's",
        description="Write the two-part mould of an actuator (3.2.1): shell and core as STL [mm], "
        "a drawing, and a report of checks that measure both files. A mould that fails a check is "
        "refused. Of a hand, a mould for each kind of actuator, all parts laid out on one bed.",
    )
    add = found.add_argument
    add("name", help="a shipped actuator, a shipped hand, or the path of a hand's YAML")
    add("-o", "--out", type=Path, default=FOLDER, help="folder (%(default)s)")
    add("--force", action="store_true", help="overwrite files in it")
    for entry in fields(MouldParameters):
        about = f"{entry.metadata['text']} [{entry.metadata['unit']}] (%(default)s)"
        option = f"--{entry.name.replace('_', '-')}"
        add(option, type=float, default=entry.default, help=about.replace("[%]", "[%%]"))
    add(
        "--split",
        type=float,
        metavar="MM",
        help="where the chamber is parted in two [mm]; one kind of actuator only",
    )
    add("--bed", type=float, nargs=2, metavar="MM", default=BED, help="size of the printing bed")
    found.set_defaults(run=run)


def run(options: argparse.Namespace) -> None:
    """Make, check and write the moulds; raises ValueError for a mould that cannot be made or fails
    a check.
    """
    if find_spec("manifold3d") is None:
        raise ValueError("mould: expected the package manifold3d, got none: pip install manifold3d")
    # late: manifold3d and matplotlib are extras, PyBullet talks when it starts
    from softhand_design.drawings.mould_drawing import draw_mould
    from softhand_design.mould.bed import lay_out, write_bed
    from softhand_design.mould.report import make_mould, paths_of, write_mould

    actuators, hand = _actuators(options.name)
    if options.split is not None and len(actuators) > 1:
        raise ValueError(
            f"--split: expected one kind of actuator, got {', '.join(actuators)}: give one name"
        )
    used = MouldParameters(**{e.name: getattr(options, e.name) for e in fields(MouldParameters)})
    planned = [path for name in actuators for path in paths_of(name, options.out).values()]
    planned += [options.out / f"{hand}_bed.stl"] if hand else []
    for path in planned:
        check_new(path, options.force)
    made, older = [], set(planned)
    try:
        for name, (actuator, turn) in actuators.items():
            made.append(make_mould(actuator, used, options.split, turn))
            paths = paths_of(name, options.out)
            older -= set(paths.values())
            write_mould(made[-1], options.out)
            save_figure(draw_mould(made[-1]), paths["drawing"])
            print(made[-1].text())
        if hand:
            bed = lay_out(made, tuple(options.bed))
            write_bed(bed, options.out / f"{hand}_bed.stl")
            print(bed.text())
    except UnwritableFile:
        raise
    except ValueError:
        for path in older:  # a mould that cannot be made leaves no file that looks like its own
            path.unlink(missing_ok=True)
        raise
    print("\n".join(str(path) for path in planned))


def _actuators(name: str) -> tuple[dict[str, tuple[Actuator, int]], str | None]:
    """The chosen kinds of actuator by the names of their moulds, with the turn of arcs in a hand,
    and the name of the hand if one was chosen.
    """
    from softhand_design.mould.parts import kind_name

    if name in actuator_names():
        return {name: (load_actuator(name), 0)}, None
    if name not in hand_names() and not Path(name).exists():
        known = ", ".join([*actuator_names(), *hand_names()])
        raise ValueError(f"name: expected one of {known}, or a hand's YAML file, got {name}")
    hand = load_hand(name)
    parts = [(part, chain.turn) for chain in hand.chains for part in chain.actuators.values()]
    return {kind_name(*part): part for part in parts}, hand.name
