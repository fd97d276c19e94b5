"""How the figures look; the only file that needs the plotting library (extra `figures`)."""

from pathlib import Path
from types import ModuleType

import matplotlib as mpl
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from pneumaticbox_driver.experiments.report import Report, Series

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
