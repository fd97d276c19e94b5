"""Stretch of sections through whole runs, compiled: what `SteppedBalance` does step by step.

All trial values, runs and sections go through one loop, run after run, so that what a specimen
keeps is known at the start of its next run. Arrays are (lanes, rows, sections) as in
`effects.stages`; rows are the samples of the runs, one run after the other.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from softhand_model.bending.balance import (
    DIFFERENCE,
    HIGHEST,
    LOWEST,
    SECANTS,
    SETTLED,
    SHORTEST,
    SMALLEST_SLOPE,
    rough_root,
)
from softhand_model.effects import Effect
from softhand_model.effects.elastic_chain import (
    LARGEST,
    SOFTENED,
    ElasticChain,
    begin_step,
    elastic_chain,
    remember,
    rest,
    sizes_of,
    stress_at,
)
from softhand_model.effects.stages import SectionShape
from softhand_model.numerics.arrays import Array, Flags, Indices
from softhand_model.numerics.compiled import compiled

LONG = 1e12  # [s] after which everything has settled
HALVES = 60  # of the range of stretches, where secants go astray
# numbers (lanes,) of one section while its balance is sought
LOAD, STRETCH, SLOPE, STRESS, MOVED, AFTER = range(6)
WORK = 6


@dataclass(frozen=True)
class Runs:
    """Runs of samples.

    starts (runs + 1,): first row of each, and the number of rows. dt (rows,) [s]: of the step to
    each sample, 0 at the first of a run. steady (runs,): whether a run has been at its first sample
    for long; others start at rest. before (runs,): the earlier run from which a specimen comes, -1
    for a virgin one.
    """

    starts: Indices
    dt: Array
    steady: Flags
    before: Indices


def stretch_in_runs(
    effects: Sequence[Effect], load: Array, shape: SectionShape, runs: Runs, mode: str
) -> Array:
    """Stretch [-] that balances a load [-] (lanes, rows, sections) at every row.

    effects: of `elastic_chain.compiled_effects`. shape: of the runs, (lanes or 1, runs, sections);
    mode: of `effects.stages.Strain`.
    """
    return _in_runs(_march, effects, load, shape, runs, mode)


def stress_in_runs(
    effects: Sequence[Effect], stretch: Array, shape: SectionShape, runs: Runs, mode: str
) -> Array:
    """Elastic side [-] at every row where the stretch [-] (lanes, rows, sections) is imposed."""
    return _in_runs(_follow, effects, stretch, shape, runs, mode)


def _in_runs(
    loop: Any,
    effects: Sequence[Effect],
    given: Array,
    shape: SectionShape,
    runs: Runs,
    mode: str,
) -> Array:
    """What a loop finds for what is given, in all lanes."""
    lanes = max([len(given), *(np.size(v) for e in effects for v in e.values.values())])
    found = np.empty((*given.shape[1:], lanes))
    loop(
        np.ascontiguousarray(np.broadcast_to(np.moveaxis(given, 0, -1), found.shape)),
        elastic_chain(effects, mode, lanes),
        sizes_of(shape, len(runs.before), given.shape[2]),
        runs.starts,
        runs.dt,
        runs.steady,
        runs.before,
        found,
    )
    return np.moveaxis(found, -1, 0)


# ---------------------------------------------------------------------- compiled
@compiled
def _march(
    load: Array,
    chain: ElasticChain,
    sizes: Array,
    starts: Indices,
    dt: Array,
    steady: Flags,
    before: Indices,
    found: Array,
) -> None:
    """Fill found (rows, sections, lanes) with the stretch."""
    _, sections, lanes = load.shape
    ends = np.ones((len(before), sections, len(chain.kinds), lanes))
    work = np.empty((WORK, lanes))
    for run in range(len(before)):
        for section in range(sections):
            chain.sizes[:] = sizes[run, section]
            _start(run, section, before, ends, chain)
            _first(load[starts[run], section], steady[run], chain, work)
            for row in range(starts[run], starts[run + 1]):
                begin_step(dt[row], chain)
                _ahead(load[row, section], work)
                _balance(chain, work)
                remember(work[STRETCH], chain, work[STRESS])
                for lane in range(lanes):
                    found[row, section, lane] = work[STRETCH, lane]
            ends[run, section] = chain.states[:, LARGEST]


@compiled
def _start(run: int, section: int, before: Indices, ends: Array, chain: ElasticChain) -> None:
    """States of a section at the start of a run."""
    rest(chain)
    if before[run] >= 0:
        for place in range(len(chain.kinds)):
            if chain.kinds[place] == SOFTENED:
                chain.states[place, LARGEST] = ends[before[run], section, place]


@compiled
def _first(load: Array, steady: bool, chain: ElasticChain, work: Array) -> None:
    """Balance before a run's first sample: at rest, or under its load for long."""
    begin_step(LONG if steady else 0.0, chain)
    for lane in range(len(load)):
        work[LOAD, lane] = load[lane] if steady else 0.0
        work[STRETCH, lane] = rough_root(work[LOAD, lane])
        work[MOVED, lane] = work[STRETCH, lane] + DIFFERENCE
    stress_at(work[STRETCH], chain, work[STRESS])
    stress_at(work[MOVED], chain, work[AFTER])
    for lane in range(len(load)):
        rise = work[AFTER, lane] - work[STRESS, lane]
        work[SLOPE, lane] = max(rise / DIFFERENCE, SMALLEST_SLOPE)
    if steady:
        _balance(chain, work)
        remember(work[STRETCH], chain, work[STRESS])


@compiled
def _ahead(load: Array, work: Array) -> None:
    """Start of the search for the next balance: on a straight line from the last one."""
    for lane in range(len(load)):
        stretch = work[STRETCH, lane]
        moved = stretch + (load[lane] - work[LOAD, lane]) / work[SLOPE, lane]
        work[STRETCH, lane] = max(moved, 0.5 * stretch)
        work[LOAD, lane] = load[lane]


@compiled
def _balance(chain: ElasticChain, work: Array) -> None:
    """Move the stretch to where it balances the load, as `balance.balance` does."""
    stretch, slope, stress = work[STRETCH], work[SLOPE], work[STRESS]
    load, moved, after = work[LOAD], work[MOVED], work[AFTER]
    stress_at(stretch, chain, stress)
    for _ in range(SECANTS):
        far = 0
        for lane in range(len(load)):
            change = (load[lane] - stress[lane]) / slope[lane]
            moved[lane] = min(max(stretch[lane] + change, 0.5 * stretch[lane]), HIGHEST)
            far += abs(change) > SETTLED
        if far == 0:
            for lane in range(len(load)):
                stretch[lane] = moved[lane]
            return
        stress_at(moved, chain, after)
        for lane in range(len(load)):
            run = moved[lane] - stretch[lane]
            long = abs(run) > SHORTEST
            secant = (after[lane] - stress[lane]) / (run if long else 1.0)
            slope[lane] = max(secant, SMALLEST_SLOPE) if long else slope[lane]
            stretch[lane], stress[lane] = moved[lane], after[lane]
    _halve(chain, work)


@compiled
def _halve(chain: ElasticChain, work: Array) -> None:
    """The same by halves of the range, where secants go astray."""
    middle, low, high = work[STRETCH], work[MOVED].copy(), work[SLOPE].copy()
    low[:], high[:] = LOWEST, HIGHEST
    for _ in range(HALVES):
        for lane in range(len(low)):
            middle[lane] = 0.5 * (low[lane] + high[lane])
        stress_at(middle, chain, work[STRESS])
        for lane in range(len(low)):
            if work[STRESS, lane] < work[LOAD, lane]:
                low[lane] = middle[lane]
            else:
                high[lane] = middle[lane]


@compiled
def _follow(
    stretch: Array,
    chain: ElasticChain,
    sizes: Array,
    starts: Indices,
    dt: Array,
    steady: Flags,
    before: Indices,
    found: Array,
) -> None:
    """Fill found (rows, sections, lanes) with the elastic side."""
    _, sections, lanes = stretch.shape
    ends = np.ones((len(before), sections, len(chain.kinds), lanes))
    for run in range(len(before)):
        for section in range(sections):
            chain.sizes[:] = sizes[run, section]
            _start(run, section, before, ends, chain)
            if steady[run]:
                begin_step(LONG, chain)
                remember(stretch[starts[run], section], chain, found[starts[run], section])
            for row in range(starts[run], starts[run + 1]):
                begin_step(dt[row], chain)
                remember(stretch[row, section], chain, found[row, section])
            ends[run, section] = chain.states[:, LARGEST]
