"""Rates of success as predicted and as they are: the error of a prediction, and a picture."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike
from scipy.stats import bootstrap

from softhand_common.numerics.arrays import Array

RESAMPLES = 2000
LEVEL = 0.95  # of intervals


def prediction_error(predicted: ArrayLike, true: ArrayLike) -> float:
    """Mean over objects of |rate predicted - rate| [-] of verdicts (objects, seeds), 1 or 0.

    >>> prediction_error([[1, 1], [0, 1]], [[1, 0], [1, 0]])
    0.25
    """
    both = np.asarray(predicted, float), np.asarray(true, float)
    return float(np.mean(np.abs(both[0].mean(axis=1) - both[1].mean(axis=1))))


def error_interval(predicted: ArrayLike, true: ArrayLike) -> tuple[float, float]:
    """Interval (95 %) of the error [-] by resampling the seeds, the same of all objects and both
    sides, as they share the places of the object.
    """
    both = np.stack([np.asarray(predicted, float), np.asarray(true, float)])

    def error(chosen: Array) -> float:
        taken = both[:, :, chosen.astype(int)]
        return prediction_error(taken[0], taken[1])

    seeds = np.arange(both.shape[2])
    found = bootstrap(
        (seeds,),
        error,
        vectorized=False,
        n_resamples=RESAMPLES,
        confidence_level=LEVEL,
        method="percentile",
        rng=np.random.default_rng(0),
    ).confidence_interval
    return float(found.low), float(found.high)


def sampling_error(verdicts: ArrayLike) -> float:
    """Standard error [-] of a rate of so many seeds, root mean square over the objects."""
    table = np.asarray(verdicts, float)
    rates = table.mean(axis=1)
    return float(np.sqrt(np.mean(rates * (1.0 - rates)) / table.shape[1]))


def draw(rates: Mapping[str, Mapping[str, list[float]]], objects: list[str], path: Path) -> None:
    """Dots of the rates [-] of success of each object, by case and by who says so."""
    import matplotlib.pyplot as plt

    figure, axes = plt.subplots(1, len(rates), figsize=(3.2 * len(rates) + 1.2, 4.2), sharey=True)
    marks = {  # colour, marker, size and fill: what comes later lies above, and hides nothing
        "base": ("tab:red", "s", 120, "none"),
        "true": ("k", "o", 60, "none"),
        "mended": ("tab:green", "D", 16, "tab:green"),
    }
    rows = np.arange(len(objects))[::-1]
    for axis, (case, series) in zip(np.ravel(axes), rates.items(), strict=True):
        for name, (colour, marker, size, fill) in marks.items():
            if name in series:
                style = {"marker": marker, "s": size, "facecolors": fill, "edgecolors": colour}
                axis.scatter(series[name], rows, label=name, zorder=3, **style)
        axis.set(title=case, xlim=(-0.05, 1.05), xlabel="rate of success", yticks=rows)
        axis.grid(alpha=0.3)
    first = np.ravel(axes)[0]
    first.set_yticklabels([name.replace("_", " ") for name in objects])
    handles, labels = first.get_legend_handles_labels()
    figure.legend(handles, labels, loc="lower center", ncols=len(marks), frameon=False)
    figure.tight_layout(rect=(0.0, 0.07, 1.0, 1.0))
    path.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(path, dpi=110)
    plt.close(figure)
