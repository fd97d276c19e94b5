"""The command `softhand-play`: the page, by default for this machine alone."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from functools import partial
from typing import TYPE_CHECKING

from grasp_strategies.trials import TrialSettings
from softhand_play.shots import World

if TYPE_CHECKING:
    from softhand_play.page import Page

HOST, PORT = "127.0.0.1", 8765


def parser() -> argparse.ArgumentParser:
    """The command line."""
    usual = TrialSettings()
    found = argparse.ArgumentParser(
        prog="softhand-play",
        description="A page in the browser to move a soft hand, to let it grasp, and to look at "
        "what was recorded.",
    )
    add = found.add_argument
    add("--hand", help="name of a shipped hand or path of its YAML (that of the strategy)")
    add("--object", default=usual.object, help="object to grasp (%(default)s)")
    add("--scene", default=usual.scene, help="what stands around it (%(default)s)")
    add("--strategy", default=usual.strategy, help="name or .yaml file (%(default)s)")
    add("--ros", action="store_true", help="show the nodes that run, and command them")
    add("--host", default=HOST, help="address to listen on (%(default)s: this machine alone)")
    add("--port", type=int, default=PORT, help="(%(default)s)")
    return found


def main(arguments: Sequence[str] | None = None) -> int:
    """Serve the page until it is interrupted; 0, or 2 when the options cannot be used."""
    options = parser().parse_args(arguments)
    try:
        page = _page(options)
    except (ValueError, OSError, RuntimeError) as error:
        print(f"softhand-play: {error}", file=sys.stderr)
        return 2
    print(f"softhand-play: http://{options.host}:{page.server.get_port()}", flush=True)
    try:
        page.run()
    except KeyboardInterrupt:
        print("softhand-play: ended")
    finally:
        page.close()
    return 0


def _page(options: argparse.Namespace) -> Page:
    """The page that is asked for; what it imports takes seconds, which --help does not have."""
    from softhand_play.page import Page

    if options.ros:
        from softhand_play.ros.live import LivePlayer

        hand = options.hand or "rbo_hand_2"
        live = partial(LivePlayer, hand, options.object, options.scene)
        return Page(options.host, options.port, live, live=True)
    from softhand_play.player import Player

    settings = TrialSettings(
        strategy=options.strategy, object=options.object, scene=options.scene, hand=options.hand
    )
    return Page(options.host, options.port, partial(Player, World(settings)))


if __name__ == "__main__":
    sys.exit(main())
