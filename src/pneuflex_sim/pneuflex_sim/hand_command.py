"""The command `hand`: design an actuator, draw any hand, write its URDF."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence

from pneuflex_sim import design_command
from pneuflex_sim.show_command import add_show
from pneuflex_sim.urdf_command import add_urdf


def parser() -> argparse.ArgumentParser:
    """The command line."""
    found = argparse.ArgumentParser(
        prog="hand", description="Design an actuator, draw any hand, write its URDF; without ROS."
    )
    commands = found.add_subparsers(dest="command", required=True)
    design_command.add_to(commands)
    add_show(commands)
    add_urdf(commands)
    return found


def main(arguments: Sequence[str] | None = None) -> int:
    """Run a command; 0, or 2 when its options cannot be used."""
    options = parser().parse_args(arguments)
    try:
        options.run(options)
    except (ValueError, OSError) as error:
        print(f"hand {options.command}: {error}", file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main())
