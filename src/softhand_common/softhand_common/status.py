"""Status reports of the parts of a node, as in REP-107, without ROS."""

from __future__ import annotations

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
    """One diagnostic status: name of the part, level, a sentence, and figures with units."""

    name: str
    level: Level = Level.OK
    message: str = "OK"
    values: dict[str, str] = field(default_factory=dict)

    def raise_to(self, level: Level, message: str) -> None:
        """Set level and sentence if the level is worse than the present one; at the same level,
        except OK, append the sentence. A better level changes nothing.
        """
        if level > self.level:
            self.level, self.message = level, message
        elif level == self.level and level > Level.OK:
            self.message = f"{self.message}; {message}"
