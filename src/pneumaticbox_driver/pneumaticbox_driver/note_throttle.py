"""Keeps notes that come again and again from flooding the log."""

from collections.abc import Iterable

NOTE_PERIOD = 5.0  # between two logs of the same note [s]


class NoteThrottle:
    """Lets each note through once in `period` [s].

    >>> throttle = NoteThrottle()
    >>> throttle.due(["tared", "tared"], 0.0), throttle.due(["tared"], 4.9)
    (['tared'], [])
    >>> throttle.due(["tared"], 5.0)
    ['tared']
    """

    def __init__(self, period: float = NOTE_PERIOD) -> None:
        self.period = period
        self._logged: dict[str, float] = {}

    def due(self, notes: Iterable[str], now: float) -> list[str]:
        """Notes to log at this monotonic time [s], in their order."""
        recent = {note: at for note, at in self._logged.items() if now - at < self.period}
        due = [note for note in dict.fromkeys(notes) if note not in recent]
        self._logged = recent | dict.fromkeys(due, now)
        return due
