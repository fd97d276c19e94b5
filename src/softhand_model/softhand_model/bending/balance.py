"""Balance of elastic side and load in bent sections under effects, step by step.

The segments of the simulator and the specimens of the lab use it. The elastic side, the elastic
stress over the shear modulus, has to rise with the stretch (`grows`), so that there is one root.
Effects have no derivative, so slopes are secants. Arrays are (lanes, rows, sections) as in
`effects.stages`.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace

import numpy as np

from softhand_common.numerics.arrays import Array, Flags
from softhand_common.numerics.compiled import compiled
from softhand_model.effects.effect import Effect
from softhand_model.effects.pipeline import StagedEffects
from softhand_model.effects.stages import SectionShape, Strain
from softhand_model.hand import section

Elastic = Callable[[Array], Array]
"""Elastic side [-] at a stretch [-]."""
Correction = Callable[[Array, Array, Array], Array]
"""Change of the stretch [-] that balances the sections, given stretch, elastic side and its slope,
by which the elastic side is taken to go on in a straight line.
"""

LOWEST_ROOT, HIGHEST_ROOT = 0.05, 60.0  # stretch: limits of the search for a root
SLOPE_DIFFERENCE = 1e-6  # of the first slope
SMALLEST_SLOPE = 0.02  # softened rubber has 0.1 and more
BALANCE_STEP = 3e-8  # last step of the stretch; the error is then of the order of its square
SHORTEST_STRETCH_STEP = 1e-10  # smallest step of the stretch that gives a slope despite rounding
BALANCE_SECANTS = 12
BALANCE_HALVES = 24
BALANCED = 1e-6  # largest relative error of the load in balance
HIGHEST_STRETCH = 4.0  # up to which the elastic side must increase
START_STEPS = 60


@dataclass(frozen=True)
class Balanced:
    """Sections in equilibrium with a load.

    stretch [-]: at which they balance it. slope [-]: derivative of the elastic stress, over the
    shear modulus, by the stretch. settled: whether the balance was found in all sections.
    """

    stretch: Array
    slope: Array
    settled: bool = True


def rough_stretch(load: Array) -> Array:
    """Stretch [-] at which q(lambda) is about the load [-], within 3 %; iterations start from it.

    >>> rough_stretch(np.array([-1.0, 0.0, 1.0, 3.0])).round(2).tolist()
    [0.83, 1.0, 1.37, 3.06]
    """
    above, below = np.maximum(load, 0.0), np.minimum(load, 0.0)
    stretched = 0.25 * above + np.cbrt(1.0 + (0.75 * above) ** 3)
    return np.asarray(stretched / np.cbrt(1.0 - 0.75 * below))


@compiled
def rough_root(load: float) -> float:
    """`rough_stretch` of a number, in compiled code, with one cube root in place of two."""
    if load < 0.0:
        return 1.0 / np.cbrt(1.0 - 0.75 * load)
    return 0.25 * load + np.cbrt(1.0 + (0.75 * load) ** 3)


def balance(elastic: Elastic, load: Array, start: Balanced | None = None) -> Balanced:
    """Stretch at which the elastic side, the elastic stress over the shear modulus, balances the
    load [-]; the search begins at `start`, if it is given.

    If the elastic side never reaches the load, the stretch is LOWEST_ROOT or HIGHEST_ROOT.

    >>> found = balance(lambda stretch: stretch - stretch**-3, np.array([3.0 - 3.0**-3]))
    >>> found.stretch.round(9).tolist()
    [3.0]
    """

    def correction(_stretch: Array, stress: Array, slope: Array) -> Array:
        """Newton step of the stretch [-]."""
        return (load - stress) / slope

    if start is None:
        start = first_slope(elastic, rough_stretch(load))
    found = iterate(elastic, correction, start)
    return found if found.settled else _bracketed(elastic, load)


def first_slope(elastic: Elastic, stretch: Array) -> Balanced:
    """A start for the iteration at this stretch, with the slope from a small difference."""
    rise = elastic(stretch + SLOPE_DIFFERENCE) - elastic(stretch)
    return Balanced(stretch, np.maximum(rise / SLOPE_DIFFERENCE, SMALLEST_SLOPE))


def iterate(
    elastic: Elastic, correction: Correction, start: Balanced, settled: float = BALANCE_STEP
) -> Balanced:
    """Secant iteration from a start, until a step is at most `settled`.

    correction: returns the next change of the stretch from stretch, stress and slope.
    """
    stretch, slope = start.stretch, start.slope
    stress = elastic(stretch)
    for _ in range(BALANCE_SECANTS):
        change = correction(stretch, stress, slope)
        # half the way to 0 at most, so that lambda**-3 stays tame
        moved = np.minimum(np.maximum(stretch + change, 0.5 * stretch), HIGHEST_ROOT)
        if np.abs(change).max() <= settled:
            return Balanced(moved, slope)
        stress_before, stress, change = stress, elastic(moved), moved - stretch
        slope = _secant(stress - stress_before, change, slope)
        stretch = moved
    return Balanced(stretch, slope, settled=False)


def _secant(rise: Array, run: Array, before: Array) -> Array:
    """Slope over the last step, or the earlier slope if the step is too small for rounding."""
    long = np.abs(run) > SHORTEST_STRETCH_STEP
    return np.where(long, np.maximum(rise / np.where(long, run, 1.0), SMALLEST_SLOPE), before)


def _bracketed(elastic: Elastic, load: Array) -> Balanced:
    """As `balance`, for elastic sides on which secants do not converge: bisection first."""
    whole = np.zeros_like(elastic(np.maximum(load, 1.0)) + load)
    low, high = whole + LOWEST_ROOT, whole + HIGHEST_ROOT
    for _ in range(BALANCE_HALVES):
        middle = 0.5 * (low + high)
        below = elastic(middle) < load
        low, high = np.where(below, middle, low), np.where(below, high, middle)

    def correction(stretch: Array, stress: Array, slope: Array) -> Array:
        """Newton step of the stretch [-], limited to the bracket."""
        return np.clip((load - stress) / slope, low - stretch, high - stretch)

    found = iterate(elastic, correction, first_slope(elastic, 0.5 * (low + high)))
    excess = np.abs(elastic(found.stretch) - load)
    return replace(found, settled=bool(np.all(excess <= BALANCED * (1.0 + np.abs(load)))))


def grows(effects: Iterable[Effect], shape: SectionShape, mode: str = "pure_shear") -> Flags:
    """Whether the elastic stress of virgin rubber under a sudden stretch increases with the
    stretch, up to a stretch of 4, at all sections: (lanes,), a single lane for effects with single
    values.

    shape: arrays (1, rows, sections). mode: mode of deformation, see `effects.stages.Strain`.
    """
    staged = StagedEffects(effects)
    growing = _in_lanes(np.array(True))
    for effect in staged.elastic:
        growing = growing & _in_lanes(np.asarray(effect.allows(shape)))
    before = None
    for stretch in np.linspace(1.0, HIGHEST_STRETCH, START_STEPS + 1):
        stress = staged.stress(Strain(np.full((1, 1, 1), stretch), mode), shape, 0.0)
        if before is not None:
            growing = growing & _in_lanes(stress > before)
        before = stress
    return growing


def _in_lanes(everywhere: Flags) -> Flags:
    """Whether a condition holds at all rows and sections of each lane."""
    lanes = np.shape(everywhere)[0] if np.ndim(everywhere) == 3 else 1
    return np.all(np.reshape(everywhere, (lanes, -1)), axis=1)


Solver = Callable[[Elastic, Array, Balanced | None], Balanced]
"""Finds the balance of an elastic side and a load [-] from a start, as `balance.balance` does."""


class SteppedBalance:
    """Sections in balance with a load that changes step by step, under effects with memory.

    mode: mode of deformation, see `effects.stages.Strain`. settled: whether the last step found a
    balance in all sections.
    """

    def __init__(self, staged: StagedEffects, mode: str = "pure_shear") -> None:
        self.staged, self.mode = staged, mode
        self.reset()

    def reset(self) -> None:
        """Reset the memory of the effects: at rest without load."""
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
        """Start of the search for the next balance, extrapolated from the last two."""
        if len(self._last) < 2:
            return self._last[0] if self._last else None
        before, last = self._last
        ahead = np.maximum(2.0 * last.stretch - before.stretch, 0.5 * last.stretch)
        return Balanced(ahead, last.slope)


def bending_load(staged: StagedEffects, pressure: Array, shape: SectionShape) -> Array:
    """Load s [-] of a chamber pressure [Pa], under the effects that change it."""
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
