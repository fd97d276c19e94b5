"""What an experiment says: figures with units, beside the thesis's, and a line of verdict."""

from collections.abc import Callable
from dataclasses import asdict, dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Series = dict[str, Floats]
Progress = Callable[[str, float], None]  # what is going on, and the share of it that is done
MG = 1e-6  # [kg]


@dataclass(frozen=True)
class Metric:
    """A figure: name, value, unit, and what the thesis has for it, if anything."""

    name: str
    value: float
    unit: str
    thesis: str = ""


@dataclass(frozen=True)
class Report:
    """Figures of an experiment and its verdict in one line."""

    metrics: tuple[Metric, ...]
    verdict: str

    def __getitem__(self, name: str) -> float:
        """Value of the metric of that name; raises KeyError."""
        return {metric.name: metric.value for metric in self.metrics}[name]

    def as_content(self) -> dict[str, Any]:
        """Return what goes into the JSON file."""
        return {"metrics": [asdict(metric) for metric in self.metrics], "verdict": self.verdict}

    def as_table(self) -> str:
        """Return the metrics as a table in Markdown.

        >>> print(Report((Metric("drift", 1.25, "mg", "< 2.5"),), "").as_table())
        | what | here | thesis |
        |---|---|---|
        | drift | 1.25 mg | < 2.5 |
        """
        rows = [f"| {m.name} | {m.value:.3g} {m.unit}".rstrip() for m in self.metrics]
        theses = [m.thesis or "-" for m in self.metrics]
        lines = [f"{row} | {thesis} |" for row, thesis in zip(rows, theses, strict=True)]
        return "\n".join(["| what | here | thesis |", "|---|---|---|", *lines])


def option(default: Any, help: str) -> Any:
    """A field of an experiment's settings, with its help; it becomes an option of the command."""
    return field(default=default, metadata={"help": help})


def rms(values: Floats, axis: int | None = None) -> Any:
    """Root of the mean square.

    >>> float(rms(np.array([3.0, 4.0]))) == 12.5**0.5
    True
    """
    return np.sqrt(np.mean(np.square(values), axis=axis))


def quiet(what: str, share: float) -> None:
    """A `Progress` that says nothing."""
