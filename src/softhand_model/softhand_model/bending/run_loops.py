"""Compiled loops through whole runs: see `whole_runs`.

Lanes are the sections of a run in all trial values; rows are the samples of the runs, one run after
the other.
"""

from __future__ import annotations

import numpy as np

from softhand_common.numerics.arrays import Array, Flags, Indices
from softhand_common.numerics.compiled import compiled
from softhand_model.bending.balance import (
    BALANCE_SECANTS,
    BALANCE_STEP,
    HIGHEST_ROOT,
    LOWEST_ROOT,
    SHORTEST_STRETCH_STEP,
    SLOPE_DIFFERENCE,
    SMALLEST_SLOPE,
    rough_root,
)
from softhand_model.bending.elastic_chain import (
    ElasticChain,
    begin_step,
    carry_over,
    remember,
    rest,
    stress_at,
)
from softhand_model.effects.whole_runs import LONG

LOOP_HALVES = 60  # bisections of the range of stretches when secants do not converge
# numbers (lanes,) of one section while its balance is sought
LOAD, STRETCH_ROW, SLOPE, STRESS, MOVED_ROW, AFTER_ROW = range(6)
WORK = 6


@compiled
def march(
    load: Array,
    chain: ElasticChain,
    sizes: Array,
    starts: Indices,
    dt: Array,
    steady: Flags,
    before: Indices,
    found: Array,
) -> None:
    """Fill found (rows, lanes) with the stretch [-] that balances a load (rows, lanes) [-], run
    after run.

    chain: of `elastic_chain`. sizes: of `sizes_of`. starts, dt, steady, before: as in
    `whole_runs.Runs`.
    """
    ends, work = _kept(before, chain), np.empty((WORK, load.shape[1]))
    for run in range(len(before)):
        _start(run, before, ends, sizes, chain)
        _first(load[starts[run]], steady[run], chain, work)
        if steady[run]:
            _balance(chain, work)
            remember(work[STRETCH_ROW], chain, work[STRESS])
        for row in range(starts[run], starts[run + 1]):
            begin_step(dt[row], chain)
            _ahead(load[row], work)
            _balance(chain, work)
            remember(work[STRETCH_ROW], chain, work[STRESS])
            for lane in range(load.shape[1]):
                found[row, lane] = work[STRETCH_ROW, lane]
        ends[run] = chain.states


@compiled
def march_at_once(
    load: Array, chain: ElasticChain, sizes: Array, starts: Indices, rows: int, found: Array
) -> None:
    """As `march`, for a chain without memory: `rows` rows of a run at once, as lanes.

    chain, sizes: for all these lanes.
    """
    for run in range(len(starts) - 1):
        chain.sizes[:] = sizes[run]
        for first in range(starts[run], starts[run + 1], rows):
            last = min(first + rows, starts[run + 1])
            part = load[first:last].reshape(-1)
            work = np.empty((WORK, len(part)))
            _first(part, True, chain, work)
            _balance(chain, work)
            found[first:last] = work[STRETCH_ROW].reshape(found[first:last].shape)


@compiled
def _kept(before: Indices, chain: ElasticChain) -> Array:
    """Array for the states (runs, m, lanes) at the end of runs."""
    return np.empty((len(before), *chain.states.shape))


@compiled
def _start(run: int, before: Indices, ends: Array, sizes: Array, chain: ElasticChain) -> None:
    """The chain at the start of a run."""
    chain.sizes[:] = sizes[run]
    rest(chain)
    if before[run] >= 0:
        carry_over(ends[before[run]], chain)


@compiled
def _first(load: Array, steady: bool, chain: ElasticChain, work: Array) -> None:
    """Start of the search for the first balance of a run: at rest, or under its load for long."""
    begin_step(LONG if steady else 0.0, chain)
    for lane in range(len(load)):
        work[LOAD, lane] = load[lane] if steady else 0.0
        work[STRETCH_ROW, lane] = rough_root(work[LOAD, lane])
        work[MOVED_ROW, lane] = work[STRETCH_ROW, lane] + SLOPE_DIFFERENCE
    stress_at(work[STRETCH_ROW], chain, work[STRESS])
    stress_at(work[MOVED_ROW], chain, work[AFTER_ROW])
    for lane in range(len(load)):
        rise = work[AFTER_ROW, lane] - work[STRESS, lane]
        work[SLOPE, lane] = max(rise / SLOPE_DIFFERENCE, SMALLEST_SLOPE)


@compiled
def _ahead(load: Array, work: Array) -> None:
    """Start of the search for the next balance, extrapolated linearly from the last one."""
    for lane in range(len(load)):
        stretch = work[STRETCH_ROW, lane]
        moved = stretch + (load[lane] - work[LOAD, lane]) / work[SLOPE, lane]
        work[STRETCH_ROW, lane] = max(moved, 0.5 * stretch)
        work[LOAD, lane] = load[lane]


@compiled
def _balance(chain: ElasticChain, work: Array) -> None:
    """Find the stretch that balances the load, as `balance.balance` does."""
    stretch, slope, stress = work[STRETCH_ROW], work[SLOPE], work[STRESS]
    load, moved, after = work[LOAD], work[MOVED_ROW], work[AFTER_ROW]
    stress_at(stretch, chain, stress)
    for _ in range(BALANCE_SECANTS):
        far = 0
        for lane in range(len(load)):
            change = (load[lane] - stress[lane]) / slope[lane]
            moved[lane] = min(max(stretch[lane] + change, 0.5 * stretch[lane]), HIGHEST_ROOT)
            far += abs(change) > BALANCE_STEP
        if far == 0:
            for lane in range(len(load)):
                stretch[lane] = moved[lane]
            return
        stress_at(moved, chain, after)
        _take_secants(work)
    _halve(chain, work)


@compiled
def _take_secants(work: Array) -> None:
    """Slopes over the last move, and the stretch after it."""
    for lane in range(work.shape[1]):
        run = work[MOVED_ROW, lane] - work[STRETCH_ROW, lane]
        long = abs(run) > SHORTEST_STRETCH_STEP
        secant = (work[AFTER_ROW, lane] - work[STRESS, lane]) / (run if long else 1.0)
        work[SLOPE, lane] = max(secant, SMALLEST_SLOPE) if long else work[SLOPE, lane]
        work[STRETCH_ROW, lane], work[STRESS, lane] = work[MOVED_ROW, lane], work[AFTER_ROW, lane]


@compiled
def _halve(chain: ElasticChain, work: Array) -> None:
    """The same by bisection of the range, when secants do not converge."""
    middle, low, high = work[STRETCH_ROW], work[MOVED_ROW].copy(), work[SLOPE].copy()
    low[:], high[:] = LOWEST_ROOT, HIGHEST_ROOT
    for _ in range(LOOP_HALVES):
        for lane in range(len(low)):
            middle[lane] = 0.5 * (low[lane] + high[lane])
        stress_at(middle, chain, work[STRESS])
        for lane in range(len(low)):
            if work[STRESS, lane] < work[LOAD, lane]:
                low[lane] = middle[lane]
            else:
                high[lane] = middle[lane]


@compiled
def follow(
    stretch: Array,
    chain: ElasticChain,
    sizes: Array,
    starts: Indices,
    dt: Array,
    steady: Flags,
    before: Indices,
    found: Array,
) -> None:
    """Fill found (rows, lanes) with the elastic stress over the shear modulus [-] at an imposed
    stretch (rows, lanes) [-]; other arguments as for `march`.
    """
    ends = _kept(before, chain)
    for run in range(len(before)):
        _start(run, before, ends, sizes, chain)
        if steady[run]:
            begin_step(LONG, chain)
            remember(stretch[starts[run]], chain, found[starts[run]])
        for row in range(starts[run], starts[run + 1]):
            begin_step(dt[row], chain)
            remember(stretch[row], chain, found[row])
        ends[run] = chain.states


# ---------------------------------------------------------------------- blocked tips
@compiled
def march_blocked(
    load: Array,
    chain: ElasticChain,
    sizes: Array,
    moment: Array,
    deflection: Array,
    compliance: Array,
    starts: Indices,
    dt: Array,
    steady: Flags,
    before: Indices,
    force: Array,
) -> None:
    """Fill force (rows, lanes) [N] of a blocked tip.

    moment, deflection (runs, sections*lanes): as `loaded_finger.Blocked.by_force` gives them.
    compliance (lanes,) [m/N]: of the force gauge. Other arguments as for `march`.
    """
    ends, work = _kept(before, chain), np.empty((WORK, load.shape[1]))
    for run in range(len(before)):
        _start(run, before, ends, sizes, chain)
        _first(load[starts[run]], steady[run], chain, work)
        if steady[run]:
            _block(moment[run], deflection[run], compliance, chain, work, force[starts[run]])
            remember(work[STRETCH_ROW], chain, work[STRESS])
        for row in range(starts[run], starts[run + 1]):
            begin_step(dt[row], chain)
            for lane in range(load.shape[1]):
                work[LOAD, lane] = load[row, lane]
            _block(moment[run], deflection[run], compliance, chain, work, force[row])
            remember(work[STRETCH_ROW], chain, work[STRESS])
        ends[run] = chain.states


@compiled
def _block(
    moment: Array,
    deflection: Array,
    compliance: Array,
    chain: ElasticChain,
    work: Array,
    force: Array,
) -> None:
    """Find the stretch that balances load and force, as `BlockedSolver` does."""
    stretch, slope, stress = work[STRETCH_ROW], work[SLOPE], work[STRESS]
    load, moved, after = work[LOAD], work[MOVED_ROW], work[AFTER_ROW]
    give, lanes = np.empty(len(force)), range(len(force))
    stress_at(stretch, chain, stress)
    for _ in range(BALANCE_SECANTS):
        for lane in lanes:
            force[lane], give[lane] = 0.0, compliance[lane]
        for first in range(0, len(load), len(force)):
            for lane in lanes:
                at = first + lane
                free = stretch[at] - 1.0 + (load[at] - stress[at]) / slope[at]
                force[lane] += deflection[at] * free
                give[lane] += deflection[at] * moment[at] / slope[at]
        for lane in lanes:
            force[lane] /= give[lane]
        far = 0
        for first in range(0, len(load), len(force)):
            for lane in lanes:
                at = first + lane
                change = (load[at] - stress[at] - moment[at] * force[lane]) / slope[at]
                moved[at] = min(max(stretch[at] + change, 0.5 * stretch[at]), HIGHEST_ROOT)
                far += abs(change) > BALANCE_STEP
        if far == 0:
            for lane in range(len(load)):
                stretch[lane] = moved[lane]
            return
        stress_at(moved, chain, after)
        _take_secants(work)
