"""Map of success over the place of the hand: region, filter, components, holes, fuzziness.

A map has one trial a cell, and jittered replicates of each cell. The thesis shows the mean of a
window of 3x3 cells (section 8.1.2), which is an average over places; a probability is estimated by
the replicates alone. A region is where at least half of the replicates succeed.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from grasp_strategies.judging.judge import OUTCOME_GRIPPED
from softhand_common.numerics.arrays import Array

Cells = NDArray[np.bool_]

REGION_SHARE = 0.5  # share of successes from which a cell belongs to the region
FUZZY_SHARES = (0.2, 0.8)  # shares between which a cell is fuzzy


@dataclass(frozen=True)
class SuccessMap:
    """Successes on a grid.

    Args:
        xs: displacements of the hand along x (nx,) [m], in even steps.
        ys: displacements along y (ny,) [m], in the same steps.
        once: success of the trial without jitter (nx, ny).
        replicates: successes with jitter (replicates, nx, ny).

    Raises:
        ValueError: the shapes do not fit, or there is no replicate.
    """

    xs: Array
    ys: Array
    once: Cells
    replicates: Cells

    def __post_init__(self) -> None:
        shape = (len(self.xs), len(self.ys))
        if (
            self.once.shape != shape
            or self.replicates.shape[1:] != shape
            or not len(self.replicates)
        ):
            raise ValueError(
                f"map: expected `once` of shape {shape} and `replicates` of shape (1 or more, "
                f"{shape[0]}, {shape[1]}), got {self.once.shape} and {self.replicates.shape}"
            )

    @cached_property
    def share(self) -> Array:
        """Share of the replicates that succeed (nx, ny) [-]."""
        return np.asarray(self.replicates.mean(axis=0))

    @cached_property
    def region(self) -> Cells:
        """Where at least half of the replicates succeed (nx, ny)."""
        return np.asarray(self.share >= REGION_SHARE)

    @cached_property
    def filtered(self) -> Array:
        """Mean of the trials without jitter over a window of 3x3 cells (nx, ny) [-]."""
        return window_mean(self.once)

    @property
    def area(self) -> float:
        """Area of the region [m2]."""
        return float(self.region.sum() * self.pitch**2)

    @property
    def equivalent_radius(self) -> float:
        """Radius of a disc with the area of the region [m]."""
        return math.sqrt(self.area / math.pi)

    @property
    def pitch(self) -> float:
        """Side of a cell [m]."""
        axis = self.xs if len(self.xs) > 1 else self.ys
        return float(axis[1] - axis[0])

    @property
    def centre(self) -> tuple[float, float]:
        """Mean place of the region's cells (x, y) [m]; NaN without a region."""
        if not self.region.any():
            return math.nan, math.nan
        x, y = np.nonzero(self.region)
        return float(self.xs[x].mean()), float(self.ys[y].mean())

    @property
    def fuzziness(self) -> float:
        """Number of cells with a share between 0.2 and 0.8, over the length of the region's border
        in sides of cells [-]; 0 if there is no such cell, infinite if there is no border.
        """
        low, high = FUZZY_SHARES
        fuzzy = int(((self.share > low) & (self.share < high)).sum())
        sides = border_length(self.region)
        if not fuzzy:
            return 0.0
        return fuzzy / sides if sides else math.inf

    @property
    def reaches_border(self) -> bool:
        """Whether a trial of the outermost ring of cells succeeds."""
        any_success = self.once | self.replicates.any(axis=0)
        inner = any_success[1:-1, 1:-1]
        return bool(any_success.sum() > inner.sum())


def window_mean(cells: Cells) -> Array:
    """Mean over a window of 3x3 cells; at the border over the cells that there are.

    >>> window_mean(np.eye(3, dtype=bool)).tolist()[0]
    [0.5, 0.3333333333333333, 0.25]
    """
    window = np.ones((3, 3))
    counts = ndimage.convolve(np.ones(cells.shape), window, mode="constant")
    return np.asarray(ndimage.convolve(cells.astype(float), window, mode="constant") / counts)


def largest_share(region: Cells) -> float:
    """Share of the cells of a region that its largest 4-connected component has [-]; NaN if empty.

    >>> largest_share(np.array([[True, False, True, True]]))
    0.6666666666666666
    """
    labels, count = ndimage.label(region)
    if not count:
        return math.nan
    return float(np.bincount(labels.ravel())[1:].max() / region.sum())


def largest_hole(region: Cells) -> int:
    """Cells of the largest hole: what the region surrounds, 4-connected.

    >>> ring = np.ones((3, 3), bool)
    >>> ring[1, 1] = False
    >>> largest_hole(ring)
    1
    """
    labels, count = ndimage.label(~np.pad(region, 1))
    outside = labels[0, 0]
    sizes = np.bincount(labels.ravel(), minlength=count + 1)
    return max((int(sizes[k]) for k in range(1, count + 1) if k != outside), default=0)


def border_length(region: Cells) -> int:
    """Length of a region's border, in sides of cells.

    >>> border_length(np.ones((1, 2), bool))
    6
    """
    padded = np.pad(region, 1).astype(int)
    return int(sum(np.abs(np.diff(padded, axis=axis)).sum() for axis in (0, 1)))


def overlap(first: Cells, second: Cells) -> float:
    """Intersection over union of two regions [-]; 1 when both are empty."""
    union = int((first | second).sum())
    return float((first & second).sum() / union) if union else 1.0


def correlation(first: Array, second: Array) -> float:
    """Pearson's correlation of two maps [-]; 1 for two constant maps of the same value, as
    `overlap` gives for empty regions; NaN if only one map is constant.
    """
    if np.ptp(first) == 0 and np.array_equal(first, second):
        return 1.0
    if np.ptp(first) == 0 or np.ptp(second) == 0:
        return math.nan
    return float(np.corrcoef(first.ravel(), second.ravel())[0, 1])


def map_of(records: Sequence[Mapping[str, Any]]) -> SuccessMap | None:
    """The map of an object's trials; None unless their cells are a grid of more than one cell, in
    even steps, and each replicate has a verdict in every cell.

    If there are no jittered replicates, the trials without jitter are used as such, and the other
    way round.

    >>> def trial(x, outcome):
    ...     return {"cell": [x, 0.0], "replicate": 1, "outcome": outcome}
    >>> map_of([trial(0.0, "none"), trial(0.01, "gripped")]).area
    0.0001
    """
    by_replicate: dict[int, dict[tuple[float, float], bool]] = {}
    for record in records:
        if "error" not in record:
            x, y = record["cell"]
            cells = by_replicate.setdefault(record["replicate"], {})
            cells[x, y] = record["outcome"] == OUTCOME_GRIPPED
    xs, ys = (np.array(sorted({float(r["cell"][axis]) for r in records})) for axis in (0, 1))
    if len(xs) * len(ys) > len(records):
        return None
    grid = [(x, y) for x in xs.tolist() for y in ys.tolist()]
    steps = np.concatenate([np.diff(xs), np.diff(ys)])
    whole = all(len(cells) == len(grid) for cells in by_replicate.values())
    if not by_replicate or not whole or not len(steps) or not np.allclose(steps, steps[0]):
        return None
    found = {
        number: np.array([by_replicate[number][cell] for cell in grid]).reshape(len(xs), len(ys))
        for number in sorted(by_replicate)
    }
    once = found[min(found)]
    jittered = [cells for number, cells in found.items() if number] or [once]
    return SuccessMap(xs, ys, once, np.array(jittered))


def finished(records: Sequence[Mapping[str, Any]]) -> Sequence[Mapping[str, Any]]:
    """The records as they are, if every trial has a verdict.

    Raises:
        RuntimeError: a trial ended in an error; the sweep tries it again when it is started again.
    """
    errors = [record for record in records if "error" in record]
    if errors:
        first = errors[0]
        raise RuntimeError(
            f"{len(errors)} trials without verdict: {first['key']}: {first['error']}"
        )
    return records
