"""What a page offers to its tabs."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Protocol

import viser


class Board(Protocol):
    """The server, the source of what is shown (`player`), and the tabs that others act on."""

    server: viser.ViserServer
    player: Any
    strategies: Any
    results: Any

    def tell(self, sentence: str) -> None:
        """Show a sentence."""

    def attempt(self, act: Callable[[], None]) -> None:
        """Do something that the user asked for; what cannot be is told."""
