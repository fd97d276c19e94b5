"""The samples of a measurement set as series: what is held out together, repeats, and outputs.

A series is one output of one run, or a contiguous block of it where blocks are held out.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from model_lab.measurement import MeasurementSet

IntArray = NDArray[np.int64]

PROTOCOLS, BLOCKS = "protocols", "blocks"
BLOCKS_A_RUN = 10  # where there are fewer than two protocols; every fifth is held out together
BLOCK_FOLDS = 5


@dataclass(frozen=True)
class Series:
    """Samples start..stop of a set laid out run after run, output after output.

    group: index of the repeats it belongs to. fold: what is held out together with it.
    """

    run: int
    output: int
    group: int
    fold: int
    start: int
    stop: int


@dataclass(frozen=True)
class SeriesLayout:
    """All series of a set in the order of its samples; `holdout` says what the folds are."""

    series: tuple[Series, ...]
    holdout: str
    folds: tuple[str, ...]

    @property
    def samples(self) -> int:
        """Number of samples of all series."""
        return self.series[-1].stop

    def fold_of(self) -> IntArray:
        """Fold of every sample (samples,)."""
        return np.concatenate([np.full(part.stop - part.start, part.fold) for part in self.series])


def series_of(data: MeasurementSet) -> SeriesLayout:
    """The series of a set; with fewer than two protocols blocks of runs are held out."""
    protocols = data.protocols()
    by_block = len(protocols) < 2
    folds = [f"block {fold + 1}" for fold in range(BLOCK_FOLDS)] if by_block else protocols
    group_of = {run: index for index, group in enumerate(data.groups()) for run in group}
    series: list[Series] = []
    start = 0
    for index, run in enumerate(data.runs):
        for output in range(len(data.outputs)):
            edges = _edges(run.samples, by_block)
            for block, (low, high) in enumerate(pairwise(edges)):
                fold = block % BLOCK_FOLDS if by_block else protocols.index(run.protocol)
                series.append(
                    Series(index, output, group_of[index], fold, start + low, start + high)
                )
            start += run.samples
    return SeriesLayout(tuple(series), BLOCKS if by_block else PROTOCOLS, tuple(folds))


def _edges(samples: int, by_block: bool) -> list[int]:
    count = min(BLOCKS_A_RUN, samples) if by_block else 1
    return [int(edge) for edge in np.linspace(0, samples, count + 1).round()]
