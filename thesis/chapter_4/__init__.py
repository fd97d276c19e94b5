"""Chapter 4: the driver on a simulated rig; units and style of its experiments."""

from typing import Any

import numpy as np

from thesis.frame import Array

MG = 1e-6  # [kg]
STEP = 2.5  # smallest step of air mass in the thesis [mg]
SEED = "number of the box, and of its noise [-]"

STYLE = {
    "figure.figsize": (8.0, 3.6),
    "savefig.dpi": 110,
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
TARGET = "#333333"
FULL = "#0072B2"  # the full model, own calibration, ours
OTHER = "#D55E00"  # the baseline, the shared calibration
SUPPLY = "#009E73"
THESIS_LINE = "#8A8A8A"  # the thesis's numbers
CHANNELS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#333333", "#B8A800")
NOTE: dict[str, Any] = {"textcoords": "offset points", "color": "#555555"}  # beside such a line


def rms(values: Array, axis: int | None = None) -> Any:
    """Root of the mean square.

    >>> float(rms(np.array([3.0, 4.0]))) == 12.5**0.5
    True
    """
    return np.sqrt(np.mean(np.square(values), axis=axis))
