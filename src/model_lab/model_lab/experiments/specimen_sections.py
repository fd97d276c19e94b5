"""Sections of the specimens of a set: where the model is evaluated along each."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from model_lab.measurement import MeasurementSet, Specimen
from model_lab.specimens import require_keys
from softhand_model import section
from softhand_model.effects.stages import SectionShape
from softhand_model.hanging import running_integral

Array = NDArray[np.float64]

POINTS = 8  # Gauss points of a size that changes in one straight line, or of a given number
POINTS_A_PIECE = 3  # of a size that changes in several
KEYS = ("length", "height", "width", "wall", "side_wall", "shear_modulus")


class SpecimenSections:
    """Sections along the specimen of each run; arrays are (1, runs, sections).

    x, weight [m]: Gauss points from the base and their weights (0 where a specimen has fewer than
    others); length (1, runs, 1) [m]; shape: with the nominal shear modulus.

    running (runs, sections, sections) [m]: integrals from the base to each point.

    uniform: whether a specimen of constant height and width counts as one section.
    Raises DocumentError for a specimen without the keys of KEYS.
    """

    def __init__(self, data: MeasurementSet, uniform: bool) -> None:
        names = dict.fromkeys(run.specimen for run in data.runs)
        for name in names:
            require_keys(data, data.specimens[name], KEYS, f"the model of {data.experiment}")
        rules = {name: _rule(data.specimens[name], uniform) for name in names}
        longest = max(len(rule.x) for rule in rules.values())
        runs = [data.specimens[run.specimen] for run in data.runs]
        padded = [rules[run.name].padded(longest) for run in runs]
        self.x = np.array([rule.x for rule in padded])[None]
        self.weight = np.array([rule.weight for rule in padded])[None]
        self.running = np.array([rule.running for rule in padded])
        self.length = numbers(runs, "length")
        self.shape = self._shape(runs)

    def _shape(self, runs: list[Specimen]) -> SectionShape:
        height, width = (
            np.array([_at(run, key, x) for run, x in zip(runs, self.x[0], strict=True)])[None]
            for key in ("height", "width")
        )
        wall, side_wall = numbers(runs, "wall"), numbers(runs, "side_wall")
        ratio = section.side_wall_ratio(height, width, wall, side_wall)
        return SectionShape(height, width, wall, side_wall, ratio, numbers(runs, "shear_modulus"))


def numbers(specimens: list[Specimen], key: str) -> Array:
    """A number (1, specimens, 1) of each specimen."""
    return np.array([specimen.values[key] for specimen in specimens], float)[None, :, None]


def circumference(data: MeasurementSet, sections: SpecimenSections) -> Array:
    """Circumference (1, runs, sections) [m]: the specimen's, or that of the rectangle."""
    around = 2.0 * (sections.shape.height + sections.shape.width)
    for row, run in enumerate(data.runs):
        specimen = data.specimens[run.specimen]
        if "circumference" in specimen.values:
            around[0, row] = _at(specimen, "circumference", sections.x[0, row])
    return around


def _at(specimen: Specimen, key: str, x: Array) -> Array:
    """A size [m] at x [m]: a number, or straight lines between points."""
    size = specimen.values[key]
    if np.ndim(size) == 0:
        return np.full_like(x, size)
    return np.interp(x, *np.asarray(size).T)


@dataclass(frozen=True)
class _Rule:
    """Gauss points and weights (n,) [m], and integrals (n, n) [m] from the base to each point."""

    x: Array
    weight: Array
    running: Array

    def padded(self, count: int) -> _Rule:
        """The rule with more points that weigh nothing."""
        more = count - len(self.x)
        return _Rule(
            np.append(self.x, np.repeat(self.x[-1:], more)),
            np.append(self.weight, np.zeros(more)),
            np.pad(self.running, (0, more)),
        )


def _rule(specimen: Specimen, uniform: bool) -> _Rule:
    """The rule on the pieces between the corners of height and width."""
    length = float(specimen.values["length"])
    sizes = [np.asarray(specimen.values[key]) for key in ("height", "width")]
    if uniform and all(size.ndim == 0 for size in sizes):
        middle = np.array([0.5 * length])
        return _Rule(middle, np.array([length]), middle[:, None])
    corners = np.concatenate([[0.0, length], *(size[:, 0] for size in sizes if size.ndim)])
    edges = np.unique(np.clip(corners, 0.0, length))
    count = max(POINTS_A_PIECE, -(-POINTS // (len(edges) - 1)))
    nodes, weights = np.polynomial.legendre.leggauss(count)
    half = np.diff(edges)[:, None] / 2.0
    x = edges[:-1, None] + half * (nodes + 1.0)
    return _Rule(x.ravel(), (half * weights).ravel(), running_integral(edges, count))
