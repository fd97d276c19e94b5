"""What the page says: a sentence, and whether it tells of a success or of an error."""

from __future__ import annotations

import html
from enum import Enum
from typing import Protocol


class Look(Enum):
    """How a sentence looks: its colour, and a sign for users who do not see colours."""

    PLAIN = ""
    SUCCESS = "✓ "
    ERROR = "⚠ "


class Report(Protocol):
    """Shows a sentence."""

    def __call__(self, sentence: str, look: Look = Look.PLAIN) -> None:
        """Show it."""


def status_html(status: str, sentence: str, look: Look) -> str:
    """The status line and the sentence as HTML; both are escaped."""
    sign = look.value if sentence else ""
    return (
        f'<div class="softhand-status"><div>{html.escape(status)}</div>'
        f'<div class="softhand-{look.name.lower()}">{sign}{html.escape(sentence)}</div></div>'
    )
