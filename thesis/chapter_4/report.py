"""What an experiment says, and its folder: figure.png, result.json, series.npz.

What an experiment says: figures with units, beside the thesis's, and a line of verdict.

How the figures look; the only file that needs the plotting library (extra `figures`).

The folder of one result: figure.png, result.json, series.npz.
"""

import json
from collections.abc import Callable
from dataclasses import asdict, dataclass, field
from importlib.metadata import version
from pathlib import Path
from types import ModuleType
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from numpy.typing import NDArray

TARGET = "#333333"
FULL = "#0072B2"  # the full model, own calibration, ours
OTHER = "#D55E00"  # the baseline, the shared calibration
SUPPLY = "#009E73"
THESIS_LINE = "#8A8A8A"  # the thesis's numbers
CHANNELS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#333333", "#B8A800")


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


STYLE = {
    "font.family": "DejaVu Sans",
    "font.size": 9,
    "axes.titlesize": 9,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.linewidth": 0.7,
    "legend.frameon": False,
    "legend.fontsize": 8,
    "lines.linewidth": 1.2,
}
SIZE = (8.0, 3.6)  # unless the experiment has a SIZE of its own [in]
DOTS = 110  # per inch


def save_figure(module: ModuleType, series: Series, report: Report, path: Path) -> None:
    """Draw the figure of an experiment into a PNG file."""
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=getattr(module, "SIZE", SIZE), layout="constrained")
        FigureCanvasAgg(figure)
        module.draw(figure, series, report)
        # no date and no program in the file: the same series give the same bytes
        figure.savefig(path, dpi=DOTS, metadata={"Software": None})


FORMAT = "pneumatics-experiment/1"


class ResultFolder:
    """Reads and writes the result of one experiment.

    Args:
        path: the folder; it is made when something is written.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self.json, self.series = path / "result.json", path / "series.npz"
        self.figure = path / "figure.png"

    def check_free(self, force: bool) -> None:
        """Refuse to write over a result unless `force`.

        Raises:
            ValueError: there is a result.
        """
        if self.json.exists() and not force:
            raise ValueError(f"{self.json} exists; --force overwrites it")

    def write(self, name: str, settings: Any, seed: int, report: Report, series: Series) -> None:
        """Write the result of the experiment `name`, and the series it comes from."""
        self.path.mkdir(parents=True, exist_ok=True)
        content = {
            "format": FORMAT,
            "experiment": name,
            "version": version("pneumaticbox_driver"),
            "seed": seed,
            "settings": asdict(settings),
            **report.as_content(),
        }
        self.json.write_text(json.dumps(content, indent=2) + "\n", encoding="utf-8")
        np.savez_compressed(self.series, **{key: _small(v) for key, v in series.items()})

    def read(self) -> tuple[dict[str, Any], Series]:
        """Return the content of the JSON file and the series.

        Raises:
            ValueError: there is none.
        """
        if not (self.json.exists() and self.series.exists()):
            raise ValueError(f"{self.path}: expected result.json and series.npz, got no such files")
        with np.load(self.series) as kept:
            series = {key: np.asarray(kept[key], dtype=float) for key in kept.files}
        return json.loads(self.json.read_text(encoding="utf-8")), series

    def draw(self, module: ModuleType, series: Series, report: Report) -> None:
        """Draw the figure of an experiment's module."""
        # here and not above: who draws nothing does not need the plotting library
        pass  # MOVED

        save_figure(module, series, report, self.figure)


def _small(values: np.ndarray) -> np.ndarray:
    return np.asarray(values, dtype=np.float32 if values.ndim > 1 else np.float64)
