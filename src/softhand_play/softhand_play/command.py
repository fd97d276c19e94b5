"""The command `softhand-play`: serves the page, by default for this machine only."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, NoReturn

from pneuflex_sim.engines import ENGINES
from softhand_play.frames import World
from softhand_trials.trials import TrialSettings

if TYPE_CHECKING:
    from softhand_play.page import Page

PROGRAM = "softhand-play"
HOST, PORT = "127.0.0.1", 8765
LAST_PORT = 65535


class _Parser(argparse.ArgumentParser):
    """An argument parser whose errors take one line."""

    def error(self, message: str) -> NoReturn:
        self.exit(2, f"{self.prog}: {message}; {self.prog} --help lists the options\n")


def parser() -> argparse.ArgumentParser:
    """The command line."""
    usual = TrialSettings()
    found = _Parser(
        prog=PROGRAM,
        description="A page in the browser to move a soft hand, to let it grasp, and to view "
        "recordings.",
    )
    add = found.add_argument
    add("--hand", help="name of a shipped hand or path of its YAML (that of the strategy)")
    add("--object", default=usual.object, help="object to grasp (%(default)s)")
    add("--scene", default=usual.scene, help="surroundings: table, wall ... (%(default)s)")
    add("--engine", choices=ENGINES, default=usual.engine, help="physics engine (%(default)s)")
    add("--strategy", default=usual.strategy, help="name or .yaml file (%(default)s)")
    add("--ros", action="store_true", help="show and command running nodes")
    add("--host", default=HOST, help="address to listen on (%(default)s: this machine only)")
    add("--port", type=_port, default=PORT, help="port; 0: any free one (%(default)s)")
    add(
        "--files",
        action="append",
        default=[],
        type=_folder,
        metavar="FOLDER",
        help="folder whose files the page may open, besides out/; can be repeated",
    )
    return found


def main(arguments: Sequence[str] | None = None) -> int:
    """Serve the page until the user interrupts it; returns 0, or 2 when the options cannot be
    used.
    """
    options = parser().parse_args(arguments)
    try:
        page = _page(options)
    except (ValueError, OSError, RuntimeError) as error:
        print(f"{PROGRAM}: {' '.join(str(error).split())}", file=sys.stderr)
        return 2
    if not page.server.access.is_local:
        print(
            f"{PROGRAM}: listens on {options.host}: everybody who can reach it and knows the "
            "address below can command the hand; the connection is not encrypted",
            file=sys.stderr,
        )
    print(f"{PROGRAM}: {page.server.address}", flush=True)
    try:
        page.run()
    except KeyboardInterrupt:
        print(f"{PROGRAM}: ended")
    finally:
        page.close()
    return 0


def _page(options: argparse.Namespace) -> Page:
    """The page for these options; imported here, as the imports take seconds and --help does not
    need them.
    """
    from softhand_play.page import Page

    settings = TrialSettings(
        strategy=options.strategy,
        object=options.object,
        scene=options.scene,
        hand=options.hand,
        engine=options.engine,
    )
    _check(settings)
    if options.ros:
        from softhand_play.ros.live import LivePlayer

        hand = options.hand or "rbo_hand_2"
        live = partial(LivePlayer, hand, options.object, options.scene)
        return Page(options.host, options.port, live, live=True)
    from softhand_play.player import Player

    player = partial(Player, World(settings))
    return Page(options.host, options.port, player, folders=options.files)


def _check(settings: TrialSettings) -> None:
    """Raise ValueError for a hand, strategy, object or scene that cannot be loaded."""
    from grasp_strategies.strategy import load_strategy
    from pneuflex_sim.scene.objects import load_object
    from pneuflex_sim.scene.scenes import load_scene
    from softhand_model.hand.hand import load_hand

    load_hand(settings.hand or load_strategy(settings.strategy).hand)
    load_strategy(settings.strategy)
    load_object(settings.object)
    load_scene(settings.scene)


def _port(text: str) -> int:
    if not (text.isdecimal() and int(text) <= LAST_PORT):
        raise argparse.ArgumentTypeError(f"expected 0 to {LAST_PORT}, got {text!r}")
    return int(text)


def _folder(text: str) -> Path:
    if not Path(text).is_dir():
        raise argparse.ArgumentTypeError(f"expected a folder, got {text!r}")
    return Path(text)


if __name__ == "__main__":
    sys.exit(main())
