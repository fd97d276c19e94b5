"""What a client knows of the box: the state at a sample and the last diagnosis, without ROS."""

from collections.abc import Mapping
from dataclasses import dataclass


class PneumaticboxError(RuntimeError):
    """The box refuses something, has vented or does not answer; the message is its sentence."""


@dataclass(frozen=True)
class BoxState:
    """State of the box at one sample, by channel.

    `time` is the stamp [s], `mass` estimated above the fill at rest [kg], `flow` into the channel
    [kg/s], `pressure` gauge [Pa].
    """

    time: float
    mass: Mapping[str, float]
    flow: Mapping[str, float]
    pressure: Mapping[str, float]


@dataclass(frozen=True)
class Diagnosis:
    """A status of `/diagnostics`: level (0 well, 1 warning, 2 error), sentence, figures."""

    level: int
    message: str
    values: Mapping[str, str]


class Complaints:
    """Finds in the diagnoses what the user of a client must hear of.

    That is a vent that was not asked for, and messages that have been refused since the beginning.
    """

    def __init__(self) -> None:
        self.vent_wanted = False
        self._refusals: int | None = None

    def of(self, diagnoses: Mapping[str, Diagnosis]) -> str:
        """Say what is wrong by the newest diagnoses by name, "" for nothing."""
        safety, commands = diagnoses.get("safety"), diagnoses.get("commands")
        refused = "" if commands is None else self._refused(commands)
        if safety is not None and safety.level > 1 and not self.vent_wanted:
            return safety.message
        return refused

    def _refused(self, commands: Diagnosis) -> str:
        count = int(commands.values.get("refused messages", 0))
        new = self._refusals is not None and count > self._refusals
        self._refusals = count
        return commands.message if new and commands.level > 0 else ""
