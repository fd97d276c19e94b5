"""The parts of a page that its tabs use."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Protocol

from softhand_play.files import AllowedFiles
from softhand_play.messages import Look
from softhand_play.page_server import PageServer


class PageContext(Protocol):
    """Server, files that may be opened, source of the frames (`player`), whether this source is
    running nodes (`live`), and the tabs that other tabs use.
    """

    server: PageServer
    files: AllowedFiles
    player: Any
    live: bool
    strategies: Any
    results: Any
    lab: Any

    def report(self, sentence: str, look: Look = Look.PLAIN) -> None:
        """Show a sentence."""

    def attempt(self, act: Callable[[], None]) -> None:
        """Carry out a request of the user; when it fails, the error is shown."""
