"""What is hidden in a set."""

from dataclasses import dataclass, field


@dataclass(frozen=True)
class Truth:
    """What a right verdict must say of a set.

    effects: for each hidden effect, the names that are right for it.
    values: by effect and parameter, the value in SI units that an interval should hold.
    slip: name of the slip, empty if none; factor: of the right unit over the stated one.
    event: kind of the fault of the series, empty if none; runs: names of the runs it concerns.
    outside: the model fails by something that the catalogue does not have.
    """

    label: str
    effects: tuple[frozenset[str], ...] = ()
    values: dict[str, dict[str, float]] = field(default_factory=dict)
    slip: str = ""
    factor: float = 1.0
    event: str = ""
    runs: tuple[str, ...] = ()
    outside: bool = False
