"""`hand show`: a picture of any hand, open and under pressure, with its dimensions."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pneuflex_sim.new_file import PICTURES, check_new
from softhand_model.hands import HandDescription, load_hand

Array = NDArray[np.float64]

KILO = 1e3
FOLDER = Path("out/hand")


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
    add("--segments", type=int, default=10, help="an actuator (%(default)s)")
    add("-o", "--out", type=Path, help=f"picture ({FOLDER}/NAME.png, always drawn anew)")
    add("--force", action="store_true", help="overwrite the file named by --out")
    found.set_defaults(run=run_show)


def run_show(options: argparse.Namespace) -> None:
    """Draw; raises ValueError for hands and pressures that cannot be used."""
    # late: designing needs neither matplotlib, an extra, nor PyBullet, which talks when it starts
    from pneuflex_sim.closing import air_masses_at, settled_hand
    from pneuflex_sim.hand_picture import draw_hand

    if options.out is not None:
        check_new(options.out, options.force, PICTURES)
    hand = load_hand(options.hand)
    gauges = [np.zeros(len(hand.channels)), *_gauges(hand, options.pressure)]
    joints = list(settled_hand(hand, np.array(gauges), options.segments))
    figure = draw_hand(hand, gauges, joints, options.segments)
    path = options.out or FOLDER / f"{hand.name}.png"
    path.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(path)
    for gauge in gauges[1:]:
        print(air_text(hand, gauge, air_masses_at(hand, gauge)))
    print(path)


def air_text(hand: HandDescription, gauge: Array, masses: Array) -> str:
    """Pressures [kPa] of the channels and the air in them [kg], as a strategy writes it."""
    named = zip(hand.channels, masses, strict=True)
    pressure = ", ".join(f"{value / KILO:.3g}" for value in gauge)
    return f"{pressure} kPa: air_mass: {{{', '.join(f'{k}: {m:.2e}' for k, m in named)}}}"


def _gauges(hand: HandDescription, given: list[str] | None) -> list[Array]:
    """Gauge pressures (channels,) [Pa] of every picture but the first."""
    from pneuflex_sim.skin_command import pressures

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
