"""Free bending of sections under effects, step by step: what the simulator's segments and the lab's
specimens have in common.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from softhand_model import section
from softhand_model.balance import Balanced, Elastic, balance
from softhand_model.effects.staged import StagedEffects
from softhand_model.effects.stages import SectionShape, Strain

Array = NDArray[np.float64]
Solver = Callable[[Elastic, Array, Balanced | None], Balanced]
"""Finds the balance of an elastic side and a load [-] from a start, as `balance.balance` does."""


class SteppedBalance:
    """Sections in balance with a load that changes step by step; effects remember the steps.

    mode: of `effects.stages.Strain`. settled: whether the last step has found a balance everywhere.
    """

    def __init__(self, staged: StagedEffects, mode: str = "pure_shear") -> None:
        self.staged, self.mode = staged, mode
        self.reset()

    def reset(self) -> None:
        """Forget everything: at rest without load."""
        self.staged.reset()
        self.settled = True
        self._last: tuple[Balanced, ...] = ()

    def stretch(
        self, load: Array, shape: SectionShape, dt: Array | float, solver: Solver = balance
    ) -> Array:
        """Stretch [-] at the end of a step of dt [s] under a load [-]."""
        staged = self.staged

        def elastic(stretch: Array) -> Array:
            return staged.stress(Strain(stretch, self.mode), shape, dt)

        found = solver(elastic, load, self._start())
        self.settled, self._last = found.settled, (*self._last[-1:], found)
        staged.remember(Strain(found.stretch, self.mode), shape, dt)
        return found.stretch

    def _start(self) -> Balanced | None:
        """Where the next balance is sought: on the straight line through the last two."""
        if len(self._last) < 2:
            return self._last[0] if self._last else None
        before, last = self._last
        ahead = np.maximum(2.0 * last.stretch - before.stretch, 0.5 * last.stretch)
        return Balanced(ahead, last.slope)


def bending_load(staged: StagedEffects, pressure: Array, shape: SectionShape) -> Array:
    """Load s [-] of a chamber pressure [Pa] with the effects that change it."""
    load = section.bending_load(
        pressure, shape.height, shape.wall, shape.ratio, shape.shear_modulus
    )
    return staged.act_on_load(load, pressure, shape)


def free_curvature(
    stepped: SteppedBalance,
    pressure: Array,
    shape: SectionShape,
    dt: Array | float,
    solver: Solver = balance,
) -> Array:
    """Curvature [1/m] of the sections at the end of a step of dt [s] at a chamber pressure [Pa]."""
    load = bending_load(stepped.staged, pressure, shape)
    curvature = (stepped.stretch(load, shape, dt, solver) - 1.0) / shape.height
    return stepped.staged.act_on_curvature(curvature, pressure, shape)
