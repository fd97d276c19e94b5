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
    columns = [np.ravel(number) for number in numbers]
    return np.stack(np.broadcast_arrays(*columns), axis=1)


def neutral_lane(
    values: Array,
    calibration: Mapping[str, Array],
    effects: Sequence[Effect],
    given: Mapping[str, float],
) -> Array:
    """Values (1, k) given by name, or at which calibration and effects do nothing; those of the
    first of the lanes (lanes, k) where there are none.
    """
    neutral = [
        given.get(name, {one.name: one.neutral for one in effect.parameters}[name])
        for effect in effects
        for name in effect.values
    ]
    pairs = zip([*(1.0 for _ in calibration), *neutral], values[0].tolist(), strict=False)
    return np.array([[first if one is None else one for one, first in pairs]]).reshape(1, -1)


def waves(values: Array, solved: int) -> list[tuple[Indices, Indices]]:
    """Lanes (n,) to be solved at the same time, wave after wave, with the lanes (n,) from which
    they begin. The first lanes, so many, have been solved already.

    Lanes follow each other so that every step is short: of those left, always the one that is
    nearest to a lane before it, by values (lanes, k) in relation to the range of all.

    >>> lanes = np.array([[0.0], [1.0], [1.1], [0.1]])
    >>> [(wave.tolist(), starts.tolist()) for wave, starts in waves(lanes, 1)]
    [([3], [0]), ([1], [3]), ([2], [1])]
    """
    spread = np.ptp(values, axis=0)
    scaled = values / np.where(spread > 0.0, spread, 1.0)
    starts, depth = np.zeros((2, len(values)), np.intp)
    nearest = np.full(len(values), np.inf)
    reached = np.arange(len(values)) < solved
    for step in range(len(values)):
        lane = step if step < solved else int(np.argmin(np.where(reached, np.inf, nearest)))
        if not reached[lane]:
            reached[lane], depth[lane] = True, depth[starts[lane]] + 1
        distance = np.sum((scaled - scaled[lane]) ** 2, axis=1)
        closer = ~reached & (distance <= nearest)  # the latest of those as near
        nearest[closer], starts[closer] = distance[closer], lane
    chosen = [np.flatnonzero(depth == level) for level in range(1, depth.max(initial=0) + 1)]
    return [(lanes, starts[lanes]) for lanes in chosen]
