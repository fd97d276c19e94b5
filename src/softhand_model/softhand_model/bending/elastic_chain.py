"""The elastic side of one section with the catalogue's elastic effects, compiled.

What `StagedEffects.stress` and `remember` do for arrays, for the loops that go through whole runs.
An effect of a user's own has no place in it: models that have one go step by step.

What relaxes or creeps is a sum of lags: each keeps what the stress is ahead of what follows it with
a time constant tau, d' = -d/tau + Q', and adds its weight times d. So over a step such an effect is
a straight line over the stress, known before the stretch is sought.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from softhand_model.effects.effect import Effect
from softhand_model.effects.elastic import (
    GentStiffening,
    ThickWall,
    YeohStiffening,
    fading,
    locking_factor,
    thickness,
)
from softhand_model.effects.elastic_memory import (
    MODES,
    RATES,
    WEIGHTS,
    Creep,
    Hysteresis,
    MullinsSoftening,
    Viscoelasticity,
    friction,
    softened,
)
from softhand_model.effects.pipeline import StagedEffects
from softhand_model.effects.stages import SectionShape
from softhand_model.effects.structure import SideWallIntegral
from softhand_model.hand.section import side_wall_integral
from softhand_model.numerics.arrays import Array, Indices
from softhand_model.numerics.compiled import compiled

PURE_SHEAR, UNIAXIAL, EQUIBIAXIAL, LINEAR = 0, 1, 2, 3
MODE_OF = {
    "pure_shear": PURE_SHEAR,
    "uniaxial": UNIAXIAL,
    "equibiaxial": EQUIBIAXIAL,
    "linear": LINEAR,
}
LOCKING, QUADRATIC, THICK, SOFTENED, LAGS, FRICTION, SIDE_WALLS = range(7)

# values of an effect: its parameters; of lags: what counts at once, then weights, then times
AT_ONCE, WEIGHT, TIME = 0, 1, 1 + MODES
VALUES = 1 + 2 * MODES
# state of an effect: of lags a straight line over the stress, the step's duration with what it
# leaves and lets through of each, the stress and what it is ahead of them; of others two numbers
SCALE, SHIFT, LASTS, BEFORE, AHEAD, LEFT, SHARE = 0, 1, 2, 3, 4, 4 + MODES, 4 + 2 * MODES
TURNED, LARGEST = 0, 0
STATE = 4 + 3 * MODES
HEIGHT, WIDTH, WALL, SIDE_WALL, RATIO = range(5)
SIZES = 5
SAME = 1e-9  # relative difference of two durations that are one


class ElasticChain(NamedTuple):
    """Elastic effects in their order, in all lanes; the sections of a run are lanes too.

    kinds (n,); values (n, VALUES, lanes); states (n, STATE, lanes); sizes (5, lanes) of the
    sections; mode: of their strain.
    """

    kinds: Indices
    values: Array
    states: Array
    sizes: Array
    mode: int


def compiled_effects(staged: StagedEffects) -> list[Effect] | None:
    """The elastic effects and walls in their order; None if one of them is not compiled."""
    effects = [*staged.elastic, *staged.walls]
    return None if any(_kind(effect) is None for effect in effects) else effects


def elastic_chain(effects: Sequence[Effect], mode: str, sections: int, lanes: int) -> ElasticChain:
    """The chain of compiled effects for so many sections, each in so many lanes, in a mode of
    `effects.stages.Strain`.
    """
    every = sections * lanes
    values = np.zeros((len(effects), VALUES, every))
    for place, effect in enumerate(effects):
        for number, column in enumerate(_values_of(effect)):
            values[place, number] = np.tile(np.broadcast_to(column, lanes), sections)
    kinds = np.array([_kind(effect) for effect in effects], np.intp)
    states = np.zeros((len(effects), STATE, every))
    return ElasticChain(kinds, values, states, np.zeros((SIZES, every)), MODE_OF[mode])


def _kind(effect: Effect) -> int | None:
    """The kind of an effect that acts as one of the catalogue does; None if it is another."""
    for known, kind in KINDS.items():
        acts = ("wall_stress",) if kind == SIDE_WALLS else ("stress", "remember")
        if all(getattr(type(effect), act, None) is getattr(known, act) for act in acts):
            return kind
    return None


def _values_of(effect: Effect) -> list[Array]:
    """Columns (lanes or 1,) of an effect's values."""
    given = [np.ravel(np.asarray(value, float)) for value in effect.values.values()]
    if isinstance(effect, Viscoelasticity):
        modulus, time = given
        unused = [np.zeros(1)] * (MODES - 1)
        return [np.ones(1), modulus, *unused, time, *unused]
    if isinstance(effect, Creep):
        share, onset = given[0] / np.log(10.0), given[1]
        weights = [share * weight for weight in WEIGHTS]
        return [1.0 - share * WEIGHTS.sum(), *weights, *(onset / rate for rate in RATES)]
    return given or [np.zeros(1)]


KINDS: Mapping[type[Effect], int] = {
    GentStiffening: LOCKING,
    YeohStiffening: QUADRATIC,
    ThickWall: THICK,
    MullinsSoftening: SOFTENED,
    Viscoelasticity: LAGS,
    Creep: LAGS,
    Hysteresis: FRICTION,
    SideWallIntegral: SIDE_WALLS,
}


def sizes_of(shape: SectionShape, runs: int, sections: int, lanes: int) -> Array:
    """Sizes (runs, 5, sections*lanes) of sections (1, runs or 1, sections or 1)."""
    parts = (shape.height, shape.width, shape.wall, shape.side_wall, shape.ratio)
    whole = [np.broadcast_to(part, (1, runs, sections))[0] for part in parts]
    return np.repeat(np.stack(whole, axis=1), lanes, axis=-1)


# ---------------------------------------------------------------------- compiled
@compiled
def stress_at(stretch: Array, chain: ElasticChain, stress: Array) -> None:
    """Fill stress (lanes,) with the elastic side [-] at a stretch (lanes,)."""
    _base_stress(stretch, chain.mode, stress)
    for place in range(len(chain.kinds)):
        _act(place, stretch, chain, stress)


@compiled
def _base_stress(stretch: Array, mode: int, stress: Array) -> None:
    """Stress of the base, as `stages.Strain` has it."""
    for lane in range(len(stretch)):
        stress[lane] = _base(stretch[lane], mode)


@compiled
def _base(stretch: float, mode: int) -> float:
    inverse = 1.0 / stretch
    if mode == PURE_SHEAR:
        return stretch - inverse * inverse * inverse
    if mode == UNIAXIAL:
        return stretch - inverse * inverse
    if mode == EQUIBIAXIAL:
        return stretch - (inverse * inverse) ** 2 * inverse
    return stretch - 1.0


@compiled
def _invariant(stretch: float, mode: int) -> float:
    """Invariant J1 [-], as `stages.Strain` has it."""
    inverse = 1.0 / stretch
    if mode == PURE_SHEAR:
        return (stretch - inverse) ** 2
    if mode == UNIAXIAL:
        return (stretch - 1.0) ** 2 * (1.0 + 2.0 * inverse)
    if mode == EQUIBIAXIAL:
        return (inverse * inverse - 1.0) ** 2 * (1.0 + 2.0 * stretch * stretch)
    return (stretch - 1.0) ** 2


@compiled
def _act(place: int, stretch: Array, chain: ElasticChain, stress: Array) -> None:
    """Change stress (lanes,) by one effect."""
    kind, mode, lanes = chain.kinds[place], chain.mode, range(len(stretch))
    values, states = chain.values[place], chain.states[place]
    if kind == LAGS:
        for lane in lanes:
            stress[lane] = stress[lane] * states[SCALE, lane] + states[SHIFT, lane]
    elif kind == FRICTION:
        for lane in lanes:
            moved = stretch[lane] - states[BEFORE, lane]
            turned = friction(moved, states[TURNED, lane], values[1, lane])
            stress[lane] += values[0, lane] * turned
    elif kind == SOFTENED:
        for lane in lanes:
            below = states[LARGEST, lane] - stretch[lane]
            if below > 0.0:
                stress[lane] *= softened(below, values[0, lane], values[1, lane])
    elif kind == LOCKING:
        for lane in lanes:
            stress[lane] *= locking_factor(_invariant(stretch[lane], mode) / values[0, lane])
    elif kind == QUADRATIC:
        for lane in lanes:
            stress[lane] *= 1.0 + 2.0 * values[0, lane] * _invariant(stretch[lane], mode)
    elif kind == THICK:
        for lane in lanes:
            share = thickness(chain.sizes[WALL, lane], chain.sizes[HEIGHT, lane])
            stress[lane] *= 1.0 + values[0, lane] * share * fading(stretch[lane])
    else:
        for lane in lanes:
            walls = _side_walls(lane, stretch[lane], chain.sizes)
            stress[lane] = 0.5 * chain.sizes[RATIO, lane] * (stress[lane] + walls)


@compiled
def _side_walls(lane: int, stretch: float, sizes: Array) -> float:
    height, wall = sizes[HEIGHT, lane], sizes[WALL, lane]
    share = 2.0 * sizes[SIDE_WALL, lane] / (height * sizes[WIDTH, lane] * wall)
    return share * side_wall_integral((stretch - 1.0) / height, max(height - wall, 0.0))


@compiled
def rest(chain: ElasticChain) -> None:
    """Forget everything: a virgin section at rest."""
    chain.states[:] = 0.0
    for place in range(len(chain.kinds)):
        kind = chain.kinds[place]
        if kind == FRICTION:
            chain.states[place, BEFORE] = 1.0
        elif kind == SOFTENED:
            chain.states[place, LARGEST] = 1.0
        elif kind == LAGS:
            chain.states[place, LASTS] = -1.0


@compiled
def begin_step(dt: float, chain: ElasticChain) -> None:
    """Make the chain ready for a step of dt [s]."""
    for place in range(len(chain.kinds)):
        if chain.kinds[place] == LAGS:
            _begin_lags(dt, chain.values[place], chain.states[place])


@compiled
def _begin_lags(dt: float, values: Array, states: Array) -> None:
    lanes = range(values.shape[1])
    if abs(dt - states[LASTS, 0]) > SAME * dt:
        states[LASTS] = dt
        for lag in range(MODES):
            for lane in lanes:
                steps = dt / values[TIME + lag, lane] if values[TIME + lag, lane] > 0.0 else 0.0
                gone = -np.expm1(-steps)
                states[LEFT + lag, lane] = 1.0 - gone
                states[SHARE + lag, lane] = gone / steps if steps > 0.0 else 1.0
    states[SCALE], states[SHIFT] = values[AT_ONCE], 0.0
    for lag in range(MODES):
        if values[TIME + lag, 0] == 0.0:
            break
        for lane in lanes:
            weight, share = values[WEIGHT + lag, lane], states[SHARE + lag, lane]
            ahead = states[LEFT + lag, lane] * states[AHEAD + lag, lane]
            states[SCALE, lane] += weight * share
            states[SHIFT, lane] += weight * (ahead - share * states[BEFORE, lane])


@compiled
def remember(stretch: Array, chain: ElasticChain, stress: Array) -> None:
    """Take over the stretch (lanes,) at the end of a step; stress as in `stress_at`."""
    _base_stress(stretch, chain.mode, stress)
    for place in range(len(chain.kinds)):
        kind, states = chain.kinds[place], chain.states[place]
        if kind == LAGS:
            _remember_lags(stress, chain.values[place], states)
        _act(place, stretch, chain, stress)
        if kind == LAGS:
            continue
        if kind == FRICTION:
            for lane in range(len(stretch)):
                moved = stretch[lane] - states[BEFORE, lane]
                turned = friction(moved, states[TURNED, lane], chain.values[place, 1, lane])
                states[TURNED, lane], states[BEFORE, lane] = turned, stretch[lane]
        elif kind == SOFTENED:
            for lane in range(len(stretch)):
                states[LARGEST, lane] = max(states[LARGEST, lane], stretch[lane])


@compiled
def _remember_lags(stress: Array, values: Array, states: Array) -> None:
    """The line over the stress stays as it was."""
    lanes = range(len(stress))
    for lag in range(MODES):
        if values[TIME + lag, 0] == 0.0:
            break
        for lane in lanes:
            ahead = states[LEFT + lag, lane] * states[AHEAD + lag, lane]
            moved = states[SHARE + lag, lane] * (stress[lane] - states[BEFORE, lane])
            states[AHEAD + lag, lane] = ahead + moved
    for lane in lanes:
        states[BEFORE, lane] = stress[lane]
