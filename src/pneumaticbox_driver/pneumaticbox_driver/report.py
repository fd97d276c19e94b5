"""What the box says about itself, as levels of REP-107."""

from dataclasses import dataclass, field
from enum import IntEnum


class Level(IntEnum):
    """Levels of a diagnostic status (REP-107)."""

    OK = 0
    WARN = 1
    ERROR = 2
    STALE = 3


@dataclass
class Report:
    """One diagnostic status: what it is about, how bad, a sentence, and figures with units."""

    name: str
    level: Level = Level.OK
    message: str = "OK"
    values: dict[str, str] = field(default_factory=dict)

    def raise_to(self, level: Level, message: str) -> None:
        """Take a worse level with its sentence; an equally bad one is appended."""
        if level > self.level:
            self.level, self.message = level, message
        elif level == self.level and level > Level.OK:
            self.message = f"{self.message}; {message}"
