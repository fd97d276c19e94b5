"""Sample table: one row for every measured number of a set, in the order of all later arrays.

The order is run after run, and within a run output after output; arrays (samples,) of the lab, such
as predictions and residuals, are laid out like the columns of this table.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import numpy as np

from model_lab.aliases import Array, IntArray
from model_lab.rules import RULES

WHOLE_PROTOCOLS, BLOCKS = "protocols", "blocks"
BLOCKS_A_RUN = 10  # where there are fewer than two protocols; every fifth is held out together
BLOCK_FOLDS = 5
BOOTSTRAP_BLOCKS = 24  # ... so many in all
SMALLEST_BLOCK = 8  # samples


@dataclass(frozen=True)
class Series:
    """Neighbouring samples start to stop - 1 of one output of one run, with what they share.

    run, output: their indices. group: index of the group of repeats of the run. fold: index of the
    fold, the part that is held out together.
    """

    run: int
    output: int
    group: int
    fold: int
    start: int
    stop: int

    @property
    def samples(self) -> slice:
        """Slice of the samples in arrays (samples,)."""
        return slice(self.start, self.stop)

    @property
    def length(self) -> int:
        """Number of samples."""
        return self.stop - self.start


@dataclass(frozen=True)
class SampleTable:
    """Columns (samples,) of a set: indices, and the measured value.

    run, output: index of the run and of the output of a sample. row: index of its time and input,
    counted through all runs. group: index of the group of runs that repeat each other. fold: index,
    into `folds`, of the part of the set that is held out together; holdout: what folds are, such as
    protocols or blocks. block: index of the part that is drawn together in a bootstrap: a run, or a
    part of a run if there are few runs (then `blocks_are_runs` is False). value: measured value in
    SI units, NaN if not measured.
    """

    run: IntArray
    output: IntArray
    row: IntArray
    group: IntArray
    fold: IntArray
    block: IntArray
    value: Array
    folds: tuple[str, ...]
    holdout: str
    blocks_are_runs: bool

    @property
    def samples(self) -> int:
        """Number of samples."""
        return len(self.value)

    @property
    def runs(self) -> int:
        """Number of runs."""
        return int(self.run[-1]) + 1

    @cached_property
    def courses(self) -> tuple[Series, ...]:
        """Every output of every run as one series, in the order of the samples."""
        return self._series(self.run, self.output)

    @cached_property
    def series(self) -> tuple[Series, ...]:
        """The courses, split where the fold changes."""
        return self._series(self.run, self.output, self.fold)

    def of_run(self, values: Array, run: int) -> Array:
        """The part (outputs, samples of the run) of values (samples,) that belongs to the run with
        this index.
        """
        start, stop = np.searchsorted(self.run, (run, run + 1))
        outputs = int(self.output[stop - 1]) + 1
        return values[start:stop].reshape(outputs, -1)

    def _series(self, *columns: IntArray) -> tuple[Series, ...]:
        """Neighbours that are alike in all the columns."""
        changes = np.any([np.diff(column) != 0 for column in columns], axis=0)
        edges = [0, *(np.flatnonzero(changes) + 1).tolist(), self.samples]
        run, output, group, fold = (
            column[edges[:-1]].tolist() for column in (self.run, self.output, self.group, self.fold)
        )
        return tuple(map(Series, run, output, group, fold, edges[:-1], edges[1:]))


def make_table(
    measured: Sequence[Array],
    groups: Sequence[Sequence[int]],
    protocols: Sequence[str],
    holdout: str = WHOLE_PROTOCOLS,
) -> SampleTable:
    """One row per sample of a measurement set, with its run and the part of the data with which it
    is held out of a fit: its protocol, or a block of its run if the set has only one protocol.

    Args:
        measured: outputs (outputs, samples) of each run in SI units.
        groups: indices of the runs of each group of repeats.
        protocols: for each run, the name of its protocol (or mode); runs with one name are held
            out together.
        holdout: what `protocols` names, such as protocols or modes.
    """
    outputs, counts = len(measured[0]), [values.shape[1] for values in measured]
    starts = np.cumsum([0, *counts]).tolist()
    row = np.concatenate([np.tile(np.arange(*ends), outputs) for ends in pairwise(starts)])
    run = np.repeat(np.arange(len(counts)), counts)[row]
    group_of = {member: index for index, group in enumerate(groups) for member in group}
    folds = list(dict.fromkeys(protocols))
    by_block = len(folds) < 2
    of_runs = np.array([folds.index(name) for name in protocols])
    fold = np.concatenate([_held_out_blocks(count) for count in counts])[row]
    return SampleTable(
        run=run,
        output=np.concatenate([np.repeat(np.arange(outputs), count) for count in counts]),
        row=row,
        group=np.array([group_of[index] for index in range(len(counts))])[run],
        fold=fold if by_block else of_runs[run],
        block=_bootstrap_blocks(counts)[row],
        value=np.concatenate([values.ravel() for values in measured]),
        folds=tuple(f"block {index + 1}" for index in range(BLOCK_FOLDS))
        if by_block
        else tuple(folds),
        holdout=BLOCKS if by_block else holdout,
        blocks_are_runs=len(counts) >= RULES.bootstrap_runs,
    )


def _held_out_blocks(samples: int) -> IntArray:
    """Fold of each row of a run that is cut into blocks."""
    blocks = min(BLOCKS_A_RUN, samples)
    edges = np.linspace(0, samples, blocks + 1).round().astype(np.int64)
    return np.repeat(np.arange(blocks) % BLOCK_FOLDS, np.diff(edges))


def _bootstrap_blocks(counts: Sequence[int]) -> IntArray:
    """Block of each row of all runs."""
    each = 1 if len(counts) >= RULES.bootstrap_runs else -(-BOOTSTRAP_BLOCKS // len(counts))
    blocks, first = [], 0
    for samples in counts:
        pieces = max(min(each, samples // SMALLEST_BLOCK), 1)
        blocks.append(first + np.arange(samples) * pieces // samples)
        first += pieces
    return np.concatenate(blocks)
