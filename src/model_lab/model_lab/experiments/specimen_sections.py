"""Sections of the specimens of a set: where the model is evaluated along each."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from model_lab.measurement import MeasurementSet, Specimen
from model_lab.specimens import require_keys
from softhand_model import section
from softhand_model.effects.stages import SectionShape

Array = NDArray[np.float64]

POINTS = 8  # Gauss points of a size that changes in one straight line, or of a given number
POINTS_A_PIECE = 3  # of a size that changes in several
KEYS = ("length", "height", "width", "wall", "side_wall", "shear_modulus")


class SpecimenSections:
    """Sections along the specimen of each run; arrays are (1, runs, sections).

    x, weight [m]: Gauss points from the base and their weights (0 where a specimen has fewer than
    others); length (1, runs, 1) [m]; shape: with the nominal shear modulus.

    uniform: whether a specimen of constant height and width counts as one section.
    Raises DocumentError for a specimen without the keys of KEYS.
    """

    def __init__(self, data: MeasurementSet, uniform: bool) -> None:
        names = dict.fromkeys(run.specimen for run in data.runs)
        for name in names:
            require_keys(data, data.specimens[name], KEYS, f"the model of {data.experiment}")
        points = {name: _points(data.specimens[name], uniform) for name in names}
        longest = max(len(x) for x, _ in points.values())
        runs = [data.specimens[run.specimen] for run in data.runs]
        padded = {name: _padded(*points[name], longest) for name in names}
        self.x = np.array([padded[run.name][0] for run in runs])[None]
        self.weight = np.array([padded[run.name][1] for run in runs])[None]
        self.length = _numbers(runs, "length")
        self.shape = self._shape(runs)

    def _shape(self, runs: list[Specimen]) -> SectionShape:
        height, width = (
            np.array([_at(run, key, x) for run, x in zip(runs, self.x[0], strict=True)])[None]
            for key in ("height", "width")
        )
        wall, side_wall = _numbers(runs, "wall"), _numbers(runs, "side_wall")
        ratio = section.side_wall_ratio(height, width, wall, side_wall)
        return SectionShape(height, width, wall, side_wall, ratio, _numbers(runs, "shear_modulus"))


def _numbers(specimens: list[Specimen], key: str) -> Array:
    return np.array([specimen.values[key] for specimen in specimens], float)[None, :, None]


def _at(specimen: Specimen, key: str, x: Array) -> Array:
    """A size [m] at x [m]: a number, or straight lines between points."""
    size = specimen.values[key]
    if np.ndim(size) == 0:
        return np.full_like(x, size)
    return np.interp(x, *np.asarray(size).T)


def _points(specimen: Specimen, uniform: bool) -> tuple[Array, Array]:
    """Gauss points and weights [m] on the pieces between the corners of height and width."""
    length = specimen.values["length"]
    sizes = [np.asarray(specimen.values[key]) for key in ("height", "width")]
    if uniform and all(size.ndim == 0 for size in sizes):
        return np.array([0.5 * length]), np.array([length])
    corners = np.concatenate([[0.0, length], *(size[:, 0] for size in sizes if size.ndim)])
    edges = np.unique(np.clip(corners, 0.0, length))
    count = max(POINTS_A_PIECE, -(-POINTS // (len(edges) - 1)))
    nodes, weights = np.polynomial.legendre.leggauss(count)
    half = np.diff(edges)[:, None] / 2.0
    x = edges[:-1, None] + half * (nodes + 1.0)
    return x.ravel(), (half * weights).ravel()


def _padded(x: Array, weight: Array, count: int) -> tuple[Array, Array]:
    more = count - len(x)
    return np.append(x, np.repeat(x[-1:], more)), np.append(weight, np.zeros(more))
