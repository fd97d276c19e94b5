"""The figure of an experiment; needs matplotlib."""

from __future__ import annotations

from pathlib import Path

from matplotlib.figure import Figure

from pneuflex_sim.validation.experiment import Experiment, Results

DPI = 130


def write_figure(experiment: Experiment, results: Results, path: Path) -> None:
    """Draw the results into a PNG file."""
    path.parent.mkdir(parents=True, exist_ok=True)
    figure = Figure(figsize=experiment.size, layout="constrained")
    experiment.draw(figure, results)
    figure.savefig(path, dpi=DPI)
