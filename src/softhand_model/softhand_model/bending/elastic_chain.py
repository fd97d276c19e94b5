"""The elastic side of sections for compiled loops through whole runs: kernels of effects, one after
the other.

It does what `StagedEffects.stress` and `remember` do for arrays. Models with an elastic effect or a
wall that has no kernel go step by step instead.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from softhand_common.numerics.arrays import Array, Indices
from softhand_common.numerics.compiled import compiled, without_allocation
from softhand_model.effects.effect import Effect
from softhand_model.effects.kernel import (
    MODE_OF,
    SIZES,
    Trial,
    base_stress,
    call_act,
    call_begin_step,
)
from softhand_model.effects.own.guard import EffectError
from softhand_model.effects.pipeline import StagedEffects
from softhand_model.effects.stages import SectionShape

# columns of `ElasticChain.kernels`: addresses, 0 for none; the rows of values and states, from the
# first to the one after the last; the row after the last state that belongs to the specimen;
# whether it is a user's own effect, whose numbers have to be checked
ACT_ADDRESS, BEGIN_ADDRESS, VALUES, VALUES_END, STATES, STATES_END, KEPT_END, OWN_FLAG = range(8)
DT, FAILED_FLAG = 0, 1


class ElasticChain(NamedTuple):
    """Kernels of n effects in their order, with all lanes; the sections of a run count as lanes
    too.

    kernels (n, 8): addresses and rows of each kernel, by the column numbers of this module. values
    (k, lanes), states (m, lanes): of all kernels. rest (m,): states of virgin sections at rest.
    sizes (5, lanes): of the sections. now (2,): DT [s], duration of the present step, and
    FAILED_FLAG, the number (from 1) of an effect whose results were not finite, else 0. mode:
    number of the mode of deformation.
    """

    kernels: Indices
    values: Array
    states: Array
    rest: Array
    sizes: Array
    now: Array
    mode: int

    def check(self, effects: Sequence[Effect]) -> None:
        """Raise EffectError if one of the effects, which must be those of the chain, has failed."""
        if self.now[FAILED_FLAG]:
            origin = effects[int(self.now[FAILED_FLAG]) - 1].origin
            raise EffectError(f"{origin}.kernel: expected finite numbers, got others")


def compiled_effects(staged: StagedEffects) -> list[Effect] | None:
    """The elastic effects and walls, in their order; None if one of them has no kernel."""
    effects = [*staged.elastic, *staged.walls]
    return None if any(effect.matching_kernel is None for effect in effects) else effects


def elastic_chain(effects: Sequence[Effect], mode: str, sections: int, lanes: int) -> ElasticChain:
    """The chain of effects, all with kernels, for a number of sections and a number of lanes each,
    in a mode of `effects.stages.Strain`.
    """
    every, table = sections * lanes, np.zeros((len(effects), OWN_FLAG + 1), np.intp)
    values: list[Array] = []
    rest: list[float] = []
    for row, effect in zip(table, effects, strict=True):
        kernel = effect.kernel
        if kernel is None:
            raise ValueError(f"effect {effect.name}: kernel: expected one, got none")
        row[ACT_ADDRESS], row[BEGIN_ADDRESS] = kernel.addresses
        row[OWN_FLAG], row[VALUES], row[STATES] = bool(effect.origin), len(values), len(rest)
        numbers = effect.kernel_values()
        values += [np.tile(np.broadcast_to(number, lanes), sections) for number in numbers]
        rest += getattr(effect, "largest", {}).values()
        row[KEPT_END] = len(rest)
        rest += kernel.rest
        row[VALUES_END], row[STATES_END] = len(values), len(rest)
    return ElasticChain(
        table,
        np.array(values).reshape(-1, every),
        np.zeros((len(rest), every)),
        np.array(rest, float),
        np.zeros((SIZES, every)),
        np.zeros(2),
        MODE_OF[mode],
    )


def sizes_of(shape: SectionShape, runs: int, sections: int, lanes: int) -> Array:
    """Sizes (runs, 5, sections*lanes) of sections whose shape is (1, runs or 1, sections or 1)."""
    parts = (shape.height, shape.width, shape.wall, shape.side_wall, shape.ratio)
    whole = [np.broadcast_to(part, (1, runs, sections))[0] for part in parts]
    return np.repeat(np.stack(whole, axis=1), lanes, axis=-1)


# ---------------------------------------------------------------------- compiled
@compiled
def rest(chain: ElasticChain) -> None:
    """Reset the states to those of a virgin section at rest."""
    for row in range(len(chain.rest)):
        chain.states[row] = chain.rest[row]


@compiled
def carry_over(ends: Array, chain: ElasticChain) -> None:
    """Copy the states that stay with the specimen from the states (m, lanes) at a run's end."""
    for place in range(len(chain.kernels)):
        for row in range(chain.kernels[place, STATES], chain.kernels[place, KEPT_END]):
            chain.states[row] = ends[row]


@without_allocation
def begin_step(dt: float, chain: ElasticChain) -> None:
    """Prepare the chain for a step of dt [s]."""
    chain.now[DT] = dt
    kernels = chain.kernels
    for place in range(len(kernels)):
        if kernels[place, BEGIN_ADDRESS] != 0:
            values = chain.values[kernels[place, VALUES] : kernels[place, VALUES_END]]
            states = chain.states[kernels[place, STATES] : kernels[place, STATES_END]]
            call_begin_step(kernels[place, BEGIN_ADDRESS], (dt, values, states))


@without_allocation
def stress_at(stretch: Array, chain: ElasticChain, stress: Array) -> None:
    """Fill stress (lanes,) with the elastic stress over the shear modulus [-] at a stretch (lanes,)
    [-].
    """
    _act(stretch, False, chain, stress)


@without_allocation
def remember(stretch: Array, chain: ElasticChain, stress: Array) -> None:
    """Update the memory with the stretch (lanes,) at a step's end; stress as in `stress_at`."""
    _act(stretch, True, chain, stress)


@without_allocation
def _act(stretch: Array, accepted: bool, chain: ElasticChain, stress: Array) -> None:
    for lane in range(len(stretch)):
        stress[lane] = base_stress(stretch[lane], chain.mode)
    trial = Trial(stretch, chain.now[DT], accepted, chain.mode, chain.sizes)
    kernels = chain.kernels
    for place in range(len(kernels)):
        values = chain.values[kernels[place, VALUES] : kernels[place, VALUES_END]]
        states = chain.states[kernels[place, STATES] : kernels[place, STATES_END]]
        call_act(kernels[place, ACT_ADDRESS], (stress, trial, values, states))
        if kernels[place, OWN_FLAG] and not _finite(stress, stretch):
            chain.now[FAILED_FLAG] = place + 1


@without_allocation
def _finite(stress: Array, stretch: Array) -> bool:
    """Whether the stress is finite wherever the stretch is, both (lanes,)."""
    for lane in range(len(stress)):
        if np.isfinite(stretch[lane]) and not np.isfinite(stress[lane]):
            return False
    return True
