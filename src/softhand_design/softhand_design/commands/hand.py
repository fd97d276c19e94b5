"""The command `softhand hand`: design an actuator, its mould, parts, picture and URDF of a hand."""

from __future__ import annotations

import sys
from collections.abc import Sequence

from pneuflex_sim.commands import hand
from softhand_design.commands import design, mould, parts


def main(arguments: Sequence[str] | None = None) -> int:
    """Run a command; returns 0, or 2 when its options cannot be used."""
    return hand.main(arguments, (design.add_to, mould.add_to, parts.add_to))


if __name__ == "__main__":
    sys.exit(main())
