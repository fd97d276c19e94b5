"""The folder of one result: figure.png, result.json, series.npz."""

import json
from dataclasses import asdict
from importlib.metadata import version
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np

from pneumaticbox_driver.experiments.report import Report, Series

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
        from pneumaticbox_driver.experiments.drawing import save_figure

        save_figure(module, series, report, self.figure)


def _small(values: np.ndarray) -> np.ndarray:
    return np.asarray(values, dtype=np.float32 if values.ndim > 1 else np.float64)
