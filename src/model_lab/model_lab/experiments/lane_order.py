"""In which order lanes of trial values are solved, each from a solved one that is near."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from softhand_model.effects import Effect

Array = NDArray[np.float64]
Indices = NDArray[np.intp]


def lane_values(calibration: Mapping[str, Array], effects: Sequence[Effect]) -> Array:
    """Values (lanes, k) of the calibration and of the effects' parameters."""
    numbers = [*calibration.values(), *(v for effect in effects for v in effect.values.values())]
    columns = [np.ravel(number) for number in numbers] or [np.zeros(1)]
    return np.stack(np.broadcast_arrays(*columns), axis=1)


def waves(values: Array, solved: int) -> list[tuple[Indices, Indices]]:
    """Lanes (n,) to be solved at the same time, wave after wave, with the lanes (n,) from which
    they begin: for each the nearest of those before it, whose values (lanes, k) differ least in
    relation to the range of all. The first lanes, so many, have been solved already.

    >>> lanes = np.array([[0.0], [1.0], [1.1], [0.1]])
    >>> [(wave.tolist(), starts.tolist()) for wave, starts in waves(lanes, 1)]
    [([1, 3], [0, 0]), ([2], [1])]
    """
    spread = np.ptp(values, axis=0)
    scaled = values / np.where(spread > 0.0, spread, 1.0)
    starts, depth = np.zeros((2, len(values)), np.intp)
    for lane in range(solved, len(values)):
        distance = np.sum((scaled[:lane] - scaled[lane]) ** 2, axis=1)
        starts[lane] = lane - 1 - np.argmin(distance[::-1])  # the latest of those as near
        depth[lane] = depth[starts[lane]] + 1
    chosen = [np.flatnonzero(depth == level) for level in range(1, depth.max(initial=0) + 1)]
    return [(lanes, starts[lanes]) for lanes in chosen]
