"""How many commands come, from whom, and how many of them were lost on the way."""

from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, field

STORM_RATE = 500.0  # above which commands are a storm [1/s]
WINDOW = 0.2  # over which the rate is taken [s]
STORM_MEMORY = 10.0  # for which a storm is worth a warning [s]


@dataclass
class CommandTraffic:
    """Counts command messages; times are of a monotonic clock [s].

    `taken` counts the messages that were looked at, `lost` those that later ones had overwritten
    before that; they can be told as long as there is one commander. `commanders` publish commands.
    """

    taken: int = 0
    lost: int = 0
    commanders: int = 0
    _sequences: dict[str, int] = field(default_factory=dict)
    _recent: deque[tuple[float, int]] = field(default_factory=deque)
    _peak: float = 0.0
    _peak_at: float = -STORM_MEMORY

    def note(self, now: float, topic: str, sequence: int, commanders: Callable[[], int]) -> None:
        """Count a message that was taken now.

        Args:
            now: present time [s].
            topic: on which it came.
            sequence: its number among those of its publisher.
            commanders: counts the publishers of the topic.
        """
        missing = sequence - self._sequences.get(topic, sequence) - 1
        # with two of them the numbers go to and fro and tell nothing
        missing = missing if missing > 0 and commanders() == 1 else 0
        self._sequences[topic] = sequence
        self.taken += 1
        self.lost += missing
        self._recent.append((now, 1 + missing))
        self._watch(now)

    def _watch(self, now: float) -> None:
        while now - self._recent[0][0] > WINDOW:
            self._recent.popleft()
        rate = sum(number for _, number in self._recent) / WINDOW
        if rate > STORM_RATE and rate > self.storm(now):
            self._peak, self._peak_at = rate, now

    def storm(self, now: float) -> float:
        """Highest rate of commands in the last storm [1/s]; 0 when there was none of late."""
        return self._peak if now - self._peak_at < STORM_MEMORY else 0.0
