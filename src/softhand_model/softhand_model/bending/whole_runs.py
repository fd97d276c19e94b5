"""Stretch of sections through whole runs, compiled: the results of `SteppedBalance`.

All trial values, runs and sections go through one loop, run after run, so that the memory of a
specimen is known at the start of its next run. Arrays are (lanes, rows, sections) as in
`effects.stages`; rows are the samples of the runs, one run after the other.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from softhand_common.numerics.arrays import Array, Indices
from softhand_model.bending.elastic_chain import (
    ElasticChain,
    compiled_effects,
    elastic_chain,
    sizes_of,
)
from softhand_model.bending.loaded_finger import Blocked
from softhand_model.bending.run_loops import follow, march, march_at_once, march_blocked
from softhand_model.effects import Effect
from softhand_model.effects.pipeline import StagedEffects
from softhand_model.effects.stages import SectionShape
from softhand_model.effects.whole_runs import RunTimes
from softhand_model.hand import section

NUMBERS_AT_ONCE = 500  # numbers of each quantity at a time, so that they fit into the cache


@dataclass(frozen=True)
class Runs(RunTimes):
    """Times of the samples of runs, and for each run the earlier run (runs,) from which its
    specimen comes: `before`, -1 for a virgin specimen.
    """

    before: Indices

    @cached_property
    def of_rows(self) -> Indices:
        """Index (rows,) of the run of each row."""
        return np.repeat(np.arange(len(self.before)), np.diff(self.starts))


def curvature_in_runs(
    staged: StagedEffects, pressure: Array, shape: SectionShape, runs: Runs
) -> Array | None:
    """Free curvature [1/m] (lanes, rows, sections) at chamber pressures [Pa] (lanes, rows, 1); None
    if an effect is not compiled.

    shape: sections of the runs, (lanes or 1, runs, sections).
    """
    effects = compiled_effects(staged)
    if effects is None:
        return None
    load = pressure * _load_per_pressure(shape, runs)
    if not staged.load and not staged.structure:
        one = shape.height.shape[-2] == 1
        height = shape.height if one else shape.height[..., runs.of_rows, :]
        return _curvature(effects, load, shape, height, runs)
    rows = shape.of_rows(runs.of_rows)
    load = staged.act_on_load(load, pressure, rows)
    curvature = _curvature(effects, load, shape, rows.height, runs)
    return staged.act_on_curvature(curvature, pressure, rows)


def _curvature(
    effects: Sequence[Effect], load: Array, shape: SectionShape, height: Array, runs: Runs
) -> Array:
    """Curvature [1/m] under a load [-], of sections so high [m], both (lanes, rows, sections)."""
    curvature = stretch_in_runs(effects, load, shape, runs, "pure_shear")
    curvature -= 1.0
    curvature /= height
    return curvature


def _load_per_pressure(shape: SectionShape, runs: Runs) -> Array:
    """Load of the base [1/Pa] (lanes or 1, rows, sections)."""
    parts = shape.height, shape.wall, shape.ratio, shape.shear_modulus
    of_runs = np.atleast_3d(section.bending_load(1.0, *parts))
    whole = np.broadcast_to(of_runs, (len(of_runs), len(runs.before), of_runs.shape[2]))
    return whole[:, runs.of_rows]


def stretch_in_runs(
    effects: Sequence[Effect], load: Array, shape: SectionShape, runs: Runs, mode: str
) -> Array:
    """Stretch [-] (lanes, rows, sections) that balances a load [-] of that shape.

    effects: of `elastic_chain.compiled_effects`. shape: sections of the runs, (lanes or 1, runs,
    sections). mode: mode of deformation, see `effects.stages.Strain`.
    """
    given = _InLoops.of(effects, load, shape, runs, mode)
    found = np.empty_like(given.input)
    if any(effect.has_memory for effect in effects):
        march(*given[1:], runs.starts, runs.dt, runs.steady, runs.before, found)
    else:
        rows = max(NUMBERS_AT_ONCE // found.shape[1], 1)
        many = given.in_rows(rows)
        march_at_once(given.input, many.chain, many.sizes, runs.starts, rows, found)
    given.chain.check(effects)
    return given.back(found)


def stress_in_runs(
    effects: Sequence[Effect], stretch: Array, shape: SectionShape, runs: Runs, mode: str
) -> Array:
    """Elastic stress over the shear modulus [-] (lanes, rows, sections) where a stretch [-] of that
    shape is imposed; other arguments as for `stretch_in_runs`.
    """
    given = _InLoops.of(effects, stretch, shape, runs, mode)
    found = np.empty_like(given.input)
    follow(*given[1:], runs.starts, runs.dt, runs.steady, runs.before, found)
    given.chain.check(effects)
    return given.back(found)


def force_in_runs(
    effects: Sequence[Effect], load: Array, shape: SectionShape, blocked: Blocked, runs: Runs
) -> Array:
    """Force [N] (lanes, rows, 1) of blocked tips under a load [-]; blocked: of the runs, see
    `loaded_finger.BlockedSolver`. Other arguments as for `stretch_in_runs`.
    """
    parts, compliance = blocked.by_force(shape), np.ravel(blocked.compliance)
    lanes = max(len(load), compliance.size, *map(len, parts))
    given = _InLoops.of(effects, load, shape, runs, "pure_shear", lanes)
    of_runs = (given.lanes, len(runs.before), load.shape[2])
    moment, deflection = (_lanes_last(part, of_runs) for part in parts)
    compliance = np.broadcast_to(compliance, given.lanes).astype(float)
    force = np.empty((load.shape[1], given.lanes))
    springs = moment, deflection, compliance
    march_blocked(*given[1:], *springs, runs.starts, runs.dt, runs.steady, runs.before, force)
    given.chain.check(effects)
    return force.T[:, :, None]


class _InLoops(NamedTuple):
    """Input of the loops: (rows, sections*lanes), chain, sizes (runs, 5, sections*lanes)."""

    lanes: int
    input: Array
    chain: ElasticChain
    sizes: Array

    @classmethod
    def of(
        cls,
        effects: Sequence[Effect],
        given: Array,
        shape: SectionShape,
        runs: Runs,
        mode: str,
        lanes: int = 1,
    ) -> _InLoops:
        """From an input (lanes, rows, sections)."""
        sections = given.shape[2]
        lanes = max([lanes, len(given), *(np.size(v) for e in effects for v in e.values.values())])
        return cls(
            lanes,
            _lanes_last(given, (lanes, *given.shape[1:])),
            elastic_chain(effects, mode, sections, lanes),
            sizes_of(shape, len(runs.before), sections, lanes),
        )

    def in_rows(self, rows: int) -> _InLoops:
        """The same for parts of the rows, side by side."""
        every, chain = rows * self.chain.sizes.shape[1], self.chain
        chain = chain._replace(
            values=np.tile(chain.values, rows),
            states=np.zeros((len(chain.states), every)),
            sizes=np.zeros((len(chain.sizes), every)),
        )
        return self._replace(chain=chain, sizes=np.tile(self.sizes, rows))

    def back(self, found: Array) -> Array:
        """A result as (lanes, rows, sections)."""
        sections = found.shape[1] // self.lanes
        return np.moveaxis(found.reshape(len(found), sections, self.lanes), -1, 0)


def _lanes_last(values: Array, shape: tuple[int, ...]) -> Array:
    """Values (lanes, rows, sections) as (rows, sections*lanes): a copy, as kernels are compiled for
    arrays that can be written.
    """
    moved = np.moveaxis(np.broadcast_to(values, shape), 0, -1)
    return np.array(moved, float, order="C").reshape(shape[1], -1)
