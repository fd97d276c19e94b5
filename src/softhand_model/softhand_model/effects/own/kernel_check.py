"""Checks on a short loading cycle that the kernel of a user's effect agrees with its methods."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numba.core.errors import NumbaError

from softhand_common.documents.quoted import shortened
from softhand_common.numerics.arrays import Array
from softhand_model.effects.effect import Effect
from softhand_model.effects.kernel import MODE_OF, Kernel, Trial
from softhand_model.effects.own.guard import EffectError, effect_errors
from softhand_model.effects.pipeline import StagedEffects
from softhand_model.effects.stages import SectionShape, Strain

CYCLE_STRETCHES = 1.0 + 0.4 * np.sin(np.linspace(0.0, 6.0, 13)) ** 2  # up and down again, twice
# [s]
CYCLE_STEPS = np.array([0.0, 0.01, 0.01, 0.02, 0.1, 0.1, 1.0, 1.0, 10.0, 0.01, 0.01, 0.5, 0.5])
CYCLE_SHARES = 0.3, 0.7  # of the usual ranges of the parameters: the trial values
CYCLE_SIZES = 0.02, 0.018, 0.0025, 0.003, 0.9  # height, width, wall, side wall [m] and ratio [-]
CLOSE = 1e-7  # relative difference of what is the same


def check_kernel(effect: type[Effect]) -> None:
    """Compare the kernel of an effect, if it has one, with its methods.

    The kernel runs as Python first, where a wrong index raises an error and does no harm, and then
    compiled.

    Raises EffectError if the kernel fails, cannot be compiled, or gives other stresses than the
    methods.
    """
    parameters = effect.parameters
    trials = effect.in_lanes(
        {p.name: [p.usual(share) for share in CYCLE_SHARES] for p in parameters}
    )
    kernel, place = trials.matching_kernel, f"{effect.origin}.kernel"
    if kernel is None:
        return
    by_methods = _by_methods(trials)
    act: Any = kernel.act  # a function of numba's, as `Kernel` has made sure
    begin_step = getattr(kernel.begin_step, "py_func", None)
    with effect_errors(place):
        found = _by_kernel(trials, kernel, act.py_func, begin_step)
    _compare(found, by_methods, f"{place}, not compiled")
    try:
        kernel.addresses  # noqa: B018, compiles them
    except (NumbaError, TypeError) as reason:
        got = shortened(str(reason).strip())
        raise EffectError(f"{place}: expected code that numba can compile, got {got}") from reason
    found = _by_kernel(trials, kernel, kernel.act, kernel.begin_step)
    _compare(found, by_methods, place)


def _by_methods(effect: Effect) -> Array:
    """Stress (steps, lanes) [-] of the loading cycle by the methods."""
    staged = StagedEffects([effect])
    shape, found = SectionShape(*(np.full((1, 1, 1), size) for size in (*CYCLE_SIZES, 1.0))), []
    for stretch, dt in zip(CYCLE_STRETCHES, CYCLE_STEPS, strict=True):
        strain = Strain(np.full((len(CYCLE_SHARES), 1, 1), stretch))
        found.append(np.broadcast_to(staged.stress(strain, shape, dt), strain.stretch.shape))
        staged.remember(strain, shape, dt)
    return np.array(found)[:, :, 0, 0]


def _by_kernel(
    effect: Effect, kernel: Kernel, act: Callable[..., Any], begin_step: Callable[..., Any] | None
) -> Array:
    """The same, as the kernel has it; act and begin_step: its functions, compiled or not."""
    lanes = len(CYCLE_SHARES)
    rows = [np.broadcast_to(row, lanes) for row in effect.kernel_values()]
    values = np.array(rows).reshape(-1, lanes)
    rest = [*getattr(effect, "largest", {}).values(), *kernel.rest]
    state = np.repeat(np.array(rest, float)[:, None], lanes, axis=1)
    sizes = np.repeat(np.array(CYCLE_SIZES)[:, None], lanes, axis=1)
    found = []
    for stretch, dt in zip(CYCLE_STRETCHES.tolist(), CYCLE_STEPS.tolist(), strict=True):
        if begin_step is not None:
            begin_step(dt, values, state)
        for accepted in (False, True):
            stress = np.full(lanes, Strain(stretch).elastic_term)
            trial = Trial(np.full(lanes, stretch), dt, accepted, MODE_OF["pure_shear"], sizes)
            act(stress, trial, values, state)
        found.append(stress)
    return np.array(found)


def _compare(found: Array, expected: Array, place: str) -> None:
    wrong = ~np.isclose(found, expected, rtol=CLOSE, atol=CLOSE)
    if wrong.any():
        step = int(np.flatnonzero(wrong.any(axis=1))[0])
        lane = int(np.flatnonzero(wrong[step])[0])
        raise EffectError(
            f"{place}: expected the stress of the class without its kernel, "
            f"{expected[step, lane]:.6g} in step {step + 1} of a loading cycle, "
            f"got {found[step, lane]:.6g}"
        )
