"""What a page offers to its tabs."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Protocol

import viser

from softhand_play.shots import Shot, Track


class Board(Protocol):
    """The server, the source of what is shown (`player`), the recorded run that is open, and the
    tab that opens results.
    """

    server: viser.ViserServer
    player: Any
    results: Any
    track: Track | None

    def tell(self, sentence: str) -> None:
        """Show a sentence."""

    def attempt(self, act: Callable[[], None]) -> None:
        """Do something that the user asked for; what cannot be is told."""

    def show(self, shot: Shot | None) -> None:
        """Look at an instant of the recorded run; None: at what goes on."""
