"""The commands `softhand hand show` and `softhand hand urdf`: draw any hand, write its URDF."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from pneuflex_sim.hand.layout import build_layout
from pneuflex_sim.urdf import write_urdf
from softhand_common.documents.output_file import PICTURES, check_new, save_figure, write_new
from softhand_common.numerics.arrays import Array
from softhand_model.hand.hand import HandDescription, load_hand
from softhand_model.model_file import load_model

KILO = 1e3
HAND_PICTURE_FOLDER = Path("out/hand")


def add_show(commands: Any) -> None:
    """Add the command to the subparsers of `hand`."""
    found = commands.add_parser(
        "show",
        help="draw any hand",
        description="Draw a hand in free air, without weight and without contact (what meets is "
        "drawn passing through): at rest and under pressure, from the side of the palm and from "
        "that of the thumb, with its dimensions. Prints the air that the pressures take.",
    )
    add = found.add_argument
    add("hand", help="name of a shipped hand or path of its YAML")
    add(
        "--pressure",
        nargs="+",
        metavar="KPA",
        help="gauge pressures [kPa], each one drawn: one number for all channels, or one for each "
        "as in 20,28,50,70 (40%% of their limits)",
    )
    add("--segments", type=int, default=10, help="segments per actuator (%(default)s)")
    add(
        "-o",
        "--out",
        type=Path,
        help=f"picture ({HAND_PICTURE_FOLDER}/NAME.png, always drawn anew)",
    )
    add("--force", action="store_true", help="overwrite the file named by --out")
    found.set_defaults(run=run_show)


def run_show(options: argparse.Namespace) -> None:
    """Draw the hand; raises ValueError for hands and pressures that cannot be used."""
    # late: designing needs neither matplotlib, an extra, nor PyBullet, which talks when it starts
    from pneuflex_sim.pictures.hand_picture import air_masses_at, draw_hand, hand_at_rest

    if options.out is not None:
        check_new(options.out, options.force, PICTURES)
    hand = load_hand(options.hand)
    wanted = np.array([np.zeros(len(hand.channels)), *_pressures(hand, options.pressure)])
    joints = list(hand_at_rest(hand, wanted, options.segments))
    figure = draw_hand(hand, wanted, joints, options.segments)
    path = options.out or HAND_PICTURE_FOLDER / f"{hand.name}.png"
    save_figure(figure, path)
    for pressures in wanted[1:]:
        print(air_text(hand, pressures, air_masses_at(hand, pressures)))
    print(path)


def air_text(hand: HandDescription, pressures: Array, masses: Array) -> str:
    """One line with the gauge pressures (channels,) [Pa], in kPa, and the air masses (channels,)
    [kg], in the form of a strategy file.
    """
    named = zip(hand.channels, masses, strict=True)
    shown = ", ".join(f"{value / KILO:.3g}" for value in pressures)
    return f"{shown} kPa: air_mass: {{{', '.join(f'{k}: {m:.2e}' for k, m in named)}}}"


def _pressures(hand: HandDescription, given: list[str] | None) -> list[Array]:
    """Gauge pressures (channels,) [Pa] of every picture but the first."""
    from pneuflex_sim.commands.skin import pressures

    if given is None:
        return [pressures(hand, None)]
    return [pressures(hand, _numbers(text), KILO, "kPa") for text in given]


def _numbers(text: str) -> list[float]:
    try:
        return [float(part) for part in text.split(",")]
    except ValueError:
        raise ValueError(
            f"pressure: expected a number [kPa], or one for each channel with commas, got {text}"
        ) from None


def add_urdf(commands: Any) -> None:
    """Add the command to the parsers of `hand`."""
    parser = commands.add_parser(
        "urdf", help="write the URDF of a hand", description="Write the URDF of a hand."
    )
    parser.add_argument("hand", help="name of a shipped hand or path of its YAML")
    parser.add_argument(
        "--segments", type=int, default=5, help="segments per actuator (%(default)s)"
    )
    parser.add_argument("-o", "--out", type=Path, help="file (standard output)")
    parser.add_argument("--force", action="store_true", help="overwrite that file")
    parser.set_defaults(run=run_urdf)


def run_urdf(options: argparse.Namespace) -> None:
    """Write the URDF; raises ValueError for a hand that does not exist or has too many segments."""
    if options.segments < 1:
        raise ValueError(f"segments: expected 1 or more, got {options.segments}")
    if options.out is not None:
        check_new(options.out, options.force)
    text = write_urdf(build_layout(load_hand(options.hand), options.segments, load_model(None)))
    if options.out is None:
        print(text)
    else:
        write_new(options.out, text + "\n", force=True)


AddCommand = Callable[[Any], Any]  # adds a command to the subparsers of `hand`


def parser(more: Sequence[AddCommand] = ()) -> argparse.ArgumentParser:
    """The command line, in which `more` commands come before those of this file."""
    found = argparse.ArgumentParser(
        prog="softhand hand", description="Work on a hand, without ROS."
    )
    commands = found.add_subparsers(dest="command", required=True)
    for add in more:
        add(commands)
    add_show(commands)
    add_urdf(commands)
    return found


def main(arguments: Sequence[str] | None = None, more: Sequence[AddCommand] = ()) -> int:
    """Run a command of this file or of `more`; returns 0, or 2 when its options cannot be used."""
    options = parser(more).parse_args(arguments)
    try:
        options.run(options)
    except (ValueError, OSError) as error:
        print(f"softhand hand {options.command}: {error}", file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main())
